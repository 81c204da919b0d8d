// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "registration/shape/spline_field.hpp"
#include "registration/similarity/lc2_cost.hpp"

namespace nav::registration {

struct DeformableOptions {
  double spacing_mm = 35;   ///< Of the control points, [10, 200].
  double bending = 3e-4;    ///< Weight of the bending energy against the cost, > 0.
  int max_iterations = 15;  ///< Of each fit, [1, 100].
  double ridge = 0.01;      ///< As ImageRegistrationOptions::ridge, > 0.
  int threads = 2;          ///< [1, 64]; the result does not depend on it.
  /// Weight of a patch: this power of its contrast, [0, 3]. A mild one: bright interfaces differ
  /// between the two pictures by what looks like a deformation, also to pictures left out.
  double contrast_power = 0.3;
  /// By how many standard errors the pictures that were left out must match better with the
  /// deformation than without, > 0.
  double min_gain_sigmas = 3;
  double min_gain_share = 0.04;  ///< And by which share of their cost, [0, 1).
  /// RMS over the patches, >= 0: less is not told from the difference between two pictures of the
  /// same edge.
  double min_displacement_mm = 1;
  double min_determinant = 0.3;  ///< Of the map's Jacobian anywhere, (0, 1).
};

/// A refusal that names the first option out of its range.
Result<void> validate(const DeformableOptions& options);

/// What became of a free-form refinement. p_ct = y + field(y), y = ct_from_reference p.
struct DeformableResult {
  SplineField field;   ///< Zero unless supported.
  bool supported;      ///< Whether the data support a deformation.
  std::string reason;  ///< One sentence, either way.
  double rigid_cost;   ///< Of all patches, [0, 1].
  double final_cost;
  /// Pictures that a fit of the others did not see: their mean cost without and with deformation.
  double held_out_rigid, held_out_deformed;
  double gain_sigmas;      ///< Their difference over its standard error.
  double displacement_mm;  ///< RMS over the patches, of the fitted field; 0 where none was fitted.
  /// Between the fields of the two halves of the pictures, RMS over the patches, mm.
  double halves_disagreement_mm;
  double min_determinant;  ///< Of the fitted map, over the box; 1 where none was fitted.
  /// No two points come nearer to each other than 1 − this share of their distance: below 1 the map
  /// is one-to-one everywhere, see SplineField::gradient_bound(). 0 where none was fitted.
  double max_gradient;
  double bending_energy_mm;  ///< Of the field, see SplineField::bending().
  int iterations;            ///< Of all fits.
};

/// Refines a rigid registration by a smooth displacement: LC² of each patch, which moves as a
/// whole, plus bending energy; Levenberg–Marquardt with a sparse Cholesky factorisation. A
/// deformation is kept only where pictures that it was not fitted to (every second of them, and
/// then the others) match better with it, and where it folds nothing; otherwise the answer is
/// rigid, and says why. Deterministic. Errors: kUsage (options), kRefused (fewer than 4 pictures
/// with patches), kNumerical (a cost that is not finite).
Result<DeformableResult> refine_deformable(const CtChannels& ct, const PatchSet& patches,
                                           const Pose& ct_from_reference,
                                           const DeformableOptions& options);

}  // namespace nav::registration
