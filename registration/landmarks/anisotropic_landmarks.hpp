// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "nav/result.hpp"
#include "registration/landmarks/landmarks.hpp"

namespace nav::registration {

/// One point seen in both frames, with the shape of its error in each: a tracker sees depth worse
/// than the rest, a CT sees along its thick slices worse.
struct AnisotropicLandmark {
  std::string name;  ///< Unique, for messages.
  Point<frames::Reference> reference;
  Point<frames::Ct> ct;
  Eigen::Matrix3d reference_covariance_mm2;  ///< Symmetric, >= 0, along Reference's axes.
  Eigen::Matrix3d ct_covariance_mm2;         ///< Symmetric, >= 0, along Ct's axes.
};

/// The rigid map of greatest likelihood: least Σ eᵀ (C + R D Rᵀ)⁻¹ e with e = ct − T·reference and
/// C, D the covariances in Ct and Reference (Ohta and Kanatani 1998; the true points are
/// eliminated). Starts from the closed form with the mean variances; Ceres, exact Jacobians.
///
/// Of the result: residuals and leave-one-out distances are in mm, unweighted; sigma_scale is
/// sqrt(Σ eᵀ(C + RDRᵀ)⁻¹e / (3N − 6)); the uncertainty comes from the covariances given.
/// Refuses what register_landmarks() refuses, and covariances that are not finite, symmetric and
/// non-negative, or whose sum has an axis outside 0.001 to 1000 mm; kNumerical when the solver does
/// not converge. Thread-safe, deterministic.
Result<LandmarkRegistration> register_anisotropic_landmarks(
    std::span<const AnisotropicLandmark> landmarks);

}  // namespace nav::registration
