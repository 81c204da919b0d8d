// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/engine.hpp"

namespace nav::render {

/// The rms error of images unless the user asks for another: half a grey level of 256.
inline constexpr double kDefaultRms = 2e-3;

/// A step and a pixel error, and the error of an image with them.
struct StepChoice {
  double step_voxels = 0;
  /// Estimated root mean square error of 8-bit colours, as a share of 255, over pixels and
  /// channels.
  double rms = 0;
  bool reached = false;    ///< false: rounding or the finest step errs more than requested.
  double pixel_error = 0;  ///< See Quality; 0: sparing rays is not worthwhile here.
};

/// Finds the step, from 4 to 1/16 voxel, and the pixel error of about the cheapest image of the
/// scene's CT whose estimated error is at most rms after rounding to 8 bits. So a user asks for an
/// accuracy; the sample distance for it depends on the volume, the transfer function, the shading
/// and the cutaway. If something is cut free, and in projections with an ultrasound image, there
/// are two searches: in the CT alone, because the objects that hide it move, and in the scene as it
/// is. The finer quality and the greater error count. Predicates and a second volume are left out
/// of the estimate. Grey projections spare no rays.
///
/// The search draws about 4000 rays, with the step halved until the image changes little. It draws
/// more rays, up to an eighth of the image's, if their errors scatter. Each step is measured
/// against a quarter of it, or of a later step. Errors are not a smooth function of the step, so
/// the step between two of them, by a power law, is drawn and measured too. ray_sparings()
/// estimates what sparing rays saves and errs. Mean squares of step, rounding and sparing add up,
/// with room for their scatter; they are split for the cheapest image by its samples. If rounding
/// leaves less than half of rms, the step is chosen for half of rms. Each search takes as long as
/// 0.2 to 3 images, most when few edges err.
///
/// Rejects an rms outside (0, 1], and what the engine rejects.
Result<StepChoice> step_for_error(Engine& engine, const Scene& scene, double rms);

/// Does the same if the result for ct_alone(scene) and rms is known already: for a CT, a camera and
/// an appearance that stay, while the plane and what is cut free of it move.
Result<StepChoice> step_for_error(Engine& engine, const Scene& scene, double rms,
                                  const StepChoice& of_ct_alone);

/// The CT of a scene without the objects that stand in it or hide it. Its quality stays, but the
/// pixel error is 0.
[[nodiscard]] Scene ct_alone(const Scene& scene);

}  // namespace nav::render
