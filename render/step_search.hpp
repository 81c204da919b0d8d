// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/engine.hpp"

namespace nav::render {

/// Rms errors of pictures that users get unless they ask for another: half a grey level of 256.
inline constexpr double kDefaultRms = 2e-3;

/// A step, and how much its picture errs.
struct StepChoice {
  double step_voxels = 0;
  /// Estimated root mean square error of colours in [0, 1], over pixels and channels.
  double rms = 0;
  bool reached = false;  ///< No more than was asked for; false: the finest step errs more.
};

/// About the coarsest step from 4 to 1/8 voxel whose picture of the scene's CT
/// is estimated to err by no more than rms: a user asks for an accuracy, and how far apart samples
/// have to lie for it depends on the volume, the transfer function and the shading. Surfaces and
/// the cutaway are left out of the estimate, and so are predicates and a second volume. Draws few
/// rays, about 3000, with the engine, at one step after the other, sqrt(2) apart, and at half of
/// it: two pictures of an integration of order p differ by 1 - 2^-p of the coarser one's error, and
/// p, which only fine steps reach, is taken from the differences themselves, between 1 and 2.
/// Between the last two steps errors are taken to follow a power of the step. Refuses an rms that
/// is not in (0, 1], and what the engine refuses.
Result<StepChoice> step_for_error(Engine& engine, const Scene& scene, double rms);

}  // namespace nav::render
