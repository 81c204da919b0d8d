// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::bench {

/// One unshaded image of the CPU engine.
struct AdaptivePoint {
  double step_voxels = 0;
  double adaptive_error = 0;  ///< 0: the fixed step.
  double cpu_ms = 0;          ///< Process time, median.
  std::uint64_t samples = 0;
  /// RMS error of colours in [0, 1] against the reference at 1/16 voxel, few pixels.
  double rms = 0;
};

/// Curves of the adaptive step and the fixed step in one scene.
struct AdaptiveCurve {
  std::string scene;
  std::vector<AdaptivePoint> points;
  /// Time of the fixed curve over that of an adaptive image at the same error; median over the
  /// adaptive images.
  double fixed_over_adaptive = 0;
};

/// Measures the CT of a scene alone: with its own transfer function, and with one of flat tissues,
/// which have a single colour and extinction over wide ranges of values.
Result<std::vector<AdaptiveCurve>> measure_adaptive(const render::Scene& scene,
                                                    const Repeats& repeats);

/// Plain-text table.
std::string to_text(const std::vector<AdaptiveCurve>& curves);

}  // namespace nav::bench
