// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "nav/result.hpp"
#include "render/engine.hpp"

namespace nav::render {

/// Sparing rays is worthwhile if it leaves at most this share of the time of an image with a ray
/// for every pixel.
inline constexpr double kSparingWorthwhile = 0.9;

/// The mean of measurements in a few positions that lie far apart.
struct Estimate {
  double mean = 0;
  double deviation = 0;  ///< Standard deviation of the mean; infinite for fewer than two values.

  static Estimate of(std::span<const double> values);
};

/// Processor time of an image, in volume samples per pixel. Samples grow with 1 / step, rays do
/// not.
struct ImageCost {
  double samples_at_one_voxel = 0;
  double rays = 0;
  [[nodiscard]] double at(double step_voxels) const {
    return samples_at_one_voxel / step_voxels + rays;
  }
};

/// The effect of a pixel error on the image of a scene.
struct Sparing {
  double pixel_error = 0;  ///< See Quality; 0: a ray for every pixel.
  Estimate error;          ///< Mean square difference from the image without it.
  ImageCost cost;          ///< Estimated for the CPU engine.
};

/// Measures the effect of sparing rays on a scene without predicates, on small parts of the image
/// at its own resolution. The first result has a ray for every pixel. The others are only those
/// that are cheaper at that step by at least a tenth. Draws nothing if no ray may be spared. Costs
/// are counted, not timed, so that they are the same each time. Errors as in Engine::render().
Result<std::vector<Sparing>> ray_sparings(Engine& engine, const Scene& scene, double step_voxels);

}  // namespace nav::render
