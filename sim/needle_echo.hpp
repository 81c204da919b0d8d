// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "sim/needle_shaft.hpp"
#include "sim/scan_geometry.hpp"

namespace nav::sim {

/// Echo of a needle in one ultrasound image: a thin bright line where the shaft lies within the
/// slice, strongest where the beam is perpendicular to it, with a brighter tip. The tissue in front
/// of it attenuates it like any echo. Private to sim/. Geometry and probe must outlive it. Reading
/// is thread-safe.
class NeedleEcho {
 public:
  NeedleEcho(const NeedleShaft& needle, const Transform<frames::Ct, frames::Image>& ct_from_image,
             const ScanGeometry& geometry, const ProbeModel& probe);
  /// True without a needle: there is nothing to add.
  [[nodiscard]] bool empty() const { return pieces_.empty(); }
  /// Adds the signal that a scan line receives, before depth gain, to all its samples. \p left:
  /// remaining amplitude of an echo from each sample after the way there and back, (0, 1].
  void add(int line, std::span<const float> left, std::span<std::complex<float>> samples) const;

 private:
  /// Straight piece of the shaft, Image coordinates.
  struct Piece {
    Eigen::Vector3d front, axis;  ///< End nearer to the tip; unit vector towards the tip.
    double length_mm;
    double behind_tip_mm;  ///< Distance from the tip to the front, along the shaft.
  };
  /// Point of the shaft that contributes most to a sample.
  struct Nearest {
    double exponent;  ///< Exponent of the amplitude, times -2; smaller is louder.
    double behind_tip_mm;
    double facing;  ///< Squared sine of the angle between beam and shaft.
  };
  void find_nearest(const Piece& piece, const ScanLine& ray, std::span<Nearest> best) const;

  const ScanGeometry& geometry_;
  const ProbeModel& probe_;
  std::vector<Piece> pieces_;
};

}  // namespace nav::sim
