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
  /// Estimated root mean square error of colours of 8 bits, as parts of 255, over pixels and
  /// channels.
  double rms = 0;
  bool reached = false;    ///< No more than was asked for; false: rounding, the adaptive error or
                           ///< the finest step errs more.
  double pixel_error = 0;  ///< Of render::Quality; 0: sparing rays does not pay in this scene.
};

/// The step, from 4 to 1/16 voxel, and the pixel error of about the cheapest picture of the scene's
/// CT that is estimated to err by no more than rms when it is rounded to 8 bits: a user asks for an
/// accuracy, and how far apart samples have to lie for it depends on the volume, the transfer
/// function, the shading and the cutaway. Where something is cut free, and in projections with an
/// ultrasound picture, it is searched twice: in the CT alone, since what hides it moves, and as the
/// scene has it; the finer quality and the greater error count. Predicates and a second volume are
/// left out of the estimate. Of a grey projection no ray is spared.
///
/// Draws some 4000 rays at steps that are halved until they change little, and more, up to an
/// eighth of the picture's, where their errors scatter: each step is measured against a quarter of
/// it, or of a later one, without quality.adaptive_error: with it, against a quarter of the finest.
/// The step between two of them, by a power law, is drawn and measured too, since errors are no
/// smooth function of it. What sparing rays saves and errs: ray_sparings(). Mean squares of step,
/// rounding and sparing add up, with room for what they scatter; the split is the one of the
/// cheapest picture by its samples. Where rounding leaves less than half of what is asked for, the
/// step is one for half of it. Each search takes as long as 0.2 to 3 pictures: most where few edges
/// err.
/// Refuses an rms that is not in (0, 1], and what the engine refuses.
Result<StepChoice> step_for_error(Engine& engine, const Scene& scene, double rms);

/// The same where what it finds for ct_alone(scene) and rms is known: of a CT, a camera and a look
/// that stay, while the plane and what is cut free of it move.
Result<StepChoice> step_for_error(Engine& engine, const Scene& scene, double rms,
                                  const StepChoice& of_ct_alone);

/// The CT of a scene without all that stands in it or hides it, at its quality but for the pixel
/// error, which is 0.
[[nodiscard]] Scene ct_alone(const Scene& scene);

}  // namespace nav::render
