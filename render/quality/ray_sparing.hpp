// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "nav/result.hpp"
#include "render/engine.hpp"

namespace nav::render {

/// Of the time of a picture with a ray for every pixel: at most what sparing rays has to leave.
inline constexpr double kSparingWorthwhile = 0.9;

/// The mean of what was measured in a few places that lie far apart.
struct Estimate {
  double mean = 0;
  double deviation = 0;  ///< Of the mean, standard; infinite for less than two values.

  static Estimate of(std::span<const double> values);
};

/// Processor time of a picture, in volume samples a pixel: samples go with 1 / step, rays do not.
struct PictureCost {
  double samples_at_one_voxel = 0;
  double rays = 0;
  [[nodiscard]] double at(double step_voxels) const {
    return samples_at_one_voxel / step_voxels + rays;
  }
};

/// What a pixel error does to the picture of a scene.
struct Sparing {
  double pixel_error = 0;  ///< Of render::Quality; 0: a ray for every pixel.
  Estimate error;          ///< Mean square between the pictures with and without.
  PictureCost cost;        ///< Estimated for the CPU engine.
};

/// What sparing rays does to a scene without predicates: measured on small
/// parts of the picture, at its own resolution. First a ray for every pixel, then only what is
/// cheaper at that step by a tenth at least; nothing is drawn where no ray may be spared. Costs are
/// counted, not timed, so that they are the same each time. Fails as the engine does.
Result<std::vector<Sparing>> ray_sparings(Engine& engine, const Scene& scene, double step_voxels);

}  // namespace nav::render
