// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/engine.hpp"

namespace nav::render {

/// Rms errors of pictures that users get unless they ask for another: half a grey level of 256.
inline constexpr double kDefaultRms = 2e-3;

/// A step and a pixel error, and how much a picture with them errs.
struct StepChoice {
  double step_voxels = 0;
  /// Estimated root mean square error of colours in [0, 1], over pixels and channels.
  double rms = 0;
  bool reached = false;    ///< No more than was asked for; false: the finest step errs more.
  double pixel_error = 0;  ///< Of render::Quality; 0: sparing rays does not pay in this scene.
};

/// The step, from 4 to 1/8 voxel, and the pixel error of about the cheapest picture of the scene's
/// CT that is estimated to err by no more than rms: a user asks for an accuracy, and how far apart
/// samples have to lie for it depends on the volume, the transfer function and the shading.
/// Surfaces and the cutaway are left out of the estimate, and so are predicates and a second
/// volume. Draws some 3000 rays at steps that are halved until they change little, and once at a
/// quarter of the last: what the others are measured against. The step between two of them, by a
/// power law, is drawn and measured too, since errors are no smooth function of it. What sparing
/// rays saves and errs is measured on six small parts of the picture; both errors add as squares,
/// and the split is the one that makes the picture cheapest by its samples. Every pixel has its ray
/// where that saves less than a tenth. Refuses an rms that is not in (0, 1], and what the engine
/// refuses.
Result<StepChoice> step_for_error(Engine& engine, const Scene& scene, double rms);

}  // namespace nav::render
