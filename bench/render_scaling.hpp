// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "nav/result.hpp"

namespace nav::bench {

struct ScalingOptions {
  std::vector<int> sides{64, 96, 128, 192, 256, 384, 512, 768};  ///< Voxels, [16, 768].
  int side = 256;   ///< Side of the volume if another axis varies.
  int width = 800;  ///< Width of the images if another axis varies, pixels.
  int height = 600;
  Repeats repeats{5, 2};
};

/// Time of one image of the cubic patient, CPU engine, shaded, half a voxel per step.
struct ScalingPoint {
  std::string axis;        ///< "side", "pixels", "threads", "occupied".
  std::string appearance;  ///< Transfer function.
  double x = 0;            ///< Voxels a side; pixels; threads; fraction of bricks occupied.
  double cpu_ms = 0;
  double wall_ms = 0;
  double prepare_ms = 0;  ///< Wall time to prepare a new volume, once.
  std::uint64_t samples = 0;
  double occupied = 0;  ///< Fraction of the bricks that may show something.
  /// Memory of all of the engine's structures for a volume, per voxel; the volume itself takes 2
  /// more. NaN on other axes.
  double bytes_per_voxel = 0;
};

/// Measures all axes in turn; progress receives the fraction done.
Result<std::vector<ScalingPoint>> measure_scaling(const ScalingOptions& options,
                                                  const std::function<void(double)>& progress = {});

/// Plain-text table.
std::string to_text(const std::vector<ScalingPoint>& points);

}  // namespace nav::bench
