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

/// One picture of the CPU engine, unshaded.
struct AdaptivePoint {
  double step_voxels = 0;
  double adaptive_error = 0;  ///< 0: the fixed step.
  double cpu_ms = 0;          ///< Process time, median.
  std::uint64_t samples = 0;
  double rms = 0;  ///< Of colours in [0, 1] against the reference at 1/16 voxel, few pixels.
};

/// The adaptive step beside the fixed one along their curves, in one scene.
struct AdaptiveCurve {
  std::string scene;
  std::vector<AdaptivePoint> points;
  /// At the error of each adaptive picture, the time of the fixed curve over its own; the median.
  double fixed_over_adaptive = 0;
};

/// The CT of a scene alone: with its own function, and with one of flat tissues, which have one
/// colour and extinction over wide ranges of values.
Result<std::vector<AdaptiveCurve>> measure_adaptive(const render::Scene& scene,
                                                    const Repeats& repeats);

/// Plain-text table.
std::string to_text(const std::vector<AdaptiveCurve>& curves);

}  // namespace nav::bench
