// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "registration/error_solver.hpp"
#include "registration/uncertainty/sandwich.hpp"

namespace nav::registration {

/// Covariance of a pose and of the errors that were estimated with it.
struct JointCovariance {
  SandwichCovariance pose;
  /// Covariance of ImageErrors::vector(); 0 for errors that were not estimated.
  Eigen::Matrix<double, kErrorParameters, kErrorParameters> errors =
      Eigen::Matrix<double, kErrorParameters, kErrorParameters>::Zero();
};

/// sandwich_covariance() of pose and errors together, at a minimum that solve_errors() found, or
/// that was found with some of the errors held:
/// Σ = M⁻¹ (S + τ P) M⁻¹ with the curvature M = H + τ P of the cost, the scatter S of its gradients
/// over cubes of 20 mm, and the prior's precision P, weighed by τ = tr(H⁻¹S)/6 as in
/// solve_errors(). The part for the pose holds whatever the errors are: an error that the sweep
/// does not show adds what it could do to the pose. Errors that were held leave the pose a Newton
/// step d away from the joint minimum: the share of d dᵀ that is not chance is added. as_recorded:
/// the patches before they were corrected; shape: of the corrected ones.
JointCovariance joint_covariance(const LocalShape& shape, const PatchSet& as_recorded,
                                 const ImageErrors& errors, const Pose& pose,
                                 const ErrorSigmas& sigmas, std::span<const ImageMotion> motions,
                                 ProbePath path, double bias_floor_mm);

}  // namespace nav::registration
