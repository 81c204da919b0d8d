// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "sim/anatomy/anatomy.hpp"
#include "sim/motion/rest_path.hpp"
#include "sim/scan_geometry.hpp"

namespace nav::sim {

/// Medium along one scan line, as far as it changes where echoes are shown and what follows gas.
/// Private to sim/.
struct LineMedium {
  /// True depth of the echo that is shown at each sample, in samples. Empty: at its true depth.
  std::vector<float> source;
  /// Depth at which the line meets gas, as shown, mm; absent: it meets none.
  std::optional<double> gas_mm;
  float gas_level = 0;  ///< Amplitude of the echo of that gas, before depth gain; 1 is white.
};

/// Follows every line of an image through the tissue. With ProbeModel::layered_speed a pulse
/// reaches the depth z after the integral of dz / c, and the scanner shows its echo at that time
/// times the speed that it assumes. The speed is averaged over the lines of the aperture; lines
/// stay straight (no refraction). \p samples: number of shown samples of a line.
std::vector<LineMedium> line_media(const Anatomy& patient, const ScanGeometry& geometry,
                                   const ProbeModel& probe, std::span<const RestPath> paths,
                                   std::size_t samples);

/// True if echoes are not shown at their true depth.
inline bool moves_echoes(const ProbeModel& probe) {
  return probe.layered_speed || probe.sound_speed != 1;
}

/// True if line_media() is needed for the images of a probe.
inline bool needs_media(const ProbeModel& probe) {
  return moves_echoes(probe) || probe.gas_haze_db > -299;
}

/// How much deeper than the image, as a factor, echoes have to be known.
inline double heard_depth(const ProbeModel& probe) {
  if (!moves_echoes(probe)) return 1;
  return std::max(1.0, (probe.layered_speed ? 1.08 : 1.0) / probe.sound_speed);
}

/// Haze below gas at a depth as shown, relative to the echo of the gas.
float haze_below_gas(const ProbeModel& probe, double below_mm);

}  // namespace nav::sim
