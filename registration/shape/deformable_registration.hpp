// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "registration/shape/spline_field.hpp"
#include "registration/similarity/similarity_cost.hpp"

namespace nav::registration {

struct DeformableOptions {
  double spacing_mm = 35;   ///< Spacing of the control points, [10, 200].
  double bending = 3e-4;    ///< Weight of the bending energy against the cost, > 0.
  int max_iterations = 15;  ///< Limit for each fit, [1, 100].
  double ridge = 0.01;      ///< See ImageRegistrationOptions::ridge, > 0.
  int threads = 2;          ///< [1, 64]; the result does not depend on it.
  /// Weight of a patch: this power of its contrast, [0, 3]. The power is small because bright
  /// interfaces differ between ultrasound and CT by something that looks like a deformation, also
  /// to images that were left out of the fit.
  double contrast_power = 0.3;
  /// Least gain of the images that were left out of the fit, in standard errors: how much better
  /// they match with the deformation than without, > 0.
  double min_gain_sigmas = 3;
  double min_gain_share = 0.04;  ///< Least gain as a fraction of their cost, [0, 1).
  /// Least displacement, RMS over the patches, >= 0: a smaller one cannot be told from the
  /// difference between two images of the same edge.
  double min_displacement_mm = 1;
  double min_determinant = 0.3;  ///< Least determinant of the map's Jacobian anywhere, (0, 1).
};

/// Returns an error that names the first option that is out of its range.
Result<void> validate(const DeformableOptions& options);

/// Result of a free-form refinement. p_ct = y + field(y), y = ct_from_reference p.
struct DeformableResult {
  SplineField field;       ///< Zero if not supported.
  bool supported = false;  ///< True if the data support a deformation.
  std::string reason{};    ///< One sentence, whether supported or not.
  double rigid_cost;       ///< Cost of all patches, [0, 1].
  double final_cost = 0;
  /// Mean cost of images that were left out of the fit, without and with deformation.
  double held_out_rigid = 0, held_out_deformed = 0;
  double gain_sigmas = 0;  ///< Their difference over its standard error.
  /// Displacement by the fitted field, RMS over the patches; 0 if none was fitted.
  double displacement_mm = 0;
  /// Difference between the fields of the two halves of the images, RMS over the patches, mm.
  double halves_disagreement_mm = 0;
  /// Least determinant of the fitted map over the box; 1 if none was fitted.
  double min_determinant;
  /// The distance of two points shrinks by at most this fraction. Below 1 the map is one-to-one
  /// everywhere, see SplineField::gradient_bound(). 0 if none was fitted.
  double max_gradient = 0;
  double bending_energy_mm = 0;  ///< Bending energy of the field, see SplineField::bending().
  int iterations = 0;            ///< Iterations of all fits.
};

/// Refines a rigid registration by a smooth displacement: LC² of each patch, which moves as a
/// whole, plus bending energy. It uses Levenberg–Marquardt with conjugate gradients. The
/// deformation is kept only if images that were left out of the fit match better with it (every
/// second image, then the others) and if it does not fold the tissue; otherwise the result is rigid
/// and says why. Deterministic. Errors: kUsage (options), kRefused (fewer than 4 images with
/// patches), kNumerical (a cost that is not finite).
Result<DeformableResult> refine_deformable(const CtChannels& ct, const PatchSet& patches,
                                           const Pose& ct_from_reference,
                                           const DeformableOptions& options);

}  // namespace nav::registration
