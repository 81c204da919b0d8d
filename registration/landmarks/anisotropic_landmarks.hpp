// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "nav/result.hpp"
#include "registration/landmarks/landmarks.hpp"

namespace nav::registration {

/// A point measured in both frames, with the covariance of its error in each. A tracker is less
/// accurate along its depth axis; a CT is less accurate across thick slices.
struct AnisotropicLandmark {
  std::string name;  ///< Unique, for messages.
  Point<frames::Reference> reference;
  Point<frames::Ct> ct;
  Eigen::Matrix3d reference_covariance_mm2;  ///< Symmetric, >= 0, along Reference's axes.
  Eigen::Matrix3d ct_covariance_mm2;         ///< Symmetric, >= 0, along Ct's axes.
};

/// Rigid registration by maximum likelihood: minimises Σ eᵀ (C + R D Rᵀ)⁻¹ e with e = ct −
/// T·reference and the covariances C in Ct and D in Reference (Ohta and Kanatani 1998; the true
/// points are eliminated). It starts from the closed form with the mean variances and uses Ceres
/// with exact Jacobians.
///
/// In the result, residuals and leave-one-out distances are in mm and unweighted; sigma_scale is
/// sqrt(Σ eᵀ(C + RDRᵀ)⁻¹e / (3N − 6)); the uncertainty comes from the given covariances. Rejects
/// what register_landmarks() rejects, and covariances that are not finite, symmetric and
/// non-negative, or whose sum has an axis outside 0.001 to 1000 mm; kNumerical if the solver does
/// not converge. Thread-safe, deterministic.
Result<LandmarkRegistration> register_anisotropic_landmarks(
    std::span<const AnisotropicLandmark> landmarks);

}  // namespace nav::registration
