// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

namespace nav::registration {

/// Range of the standard deviations of a point that the computation supports, mm.
inline constexpr double kLeastSigmaMm = 1e-3;
inline constexpr double kGreatestSigmaMm = 1e3;

/// Largest number of landmarks. Nobody touches more by hand; larger sets of points are registered
/// to a surface (shape_registration.hpp).
inline constexpr std::size_t kMostLandmarks = 1000;

/// An anatomical or fiducial point, measured in both frames.
struct LandmarkPair {
  std::string name;                    ///< Unique, for messages.
  Point<frames::Reference> reference;  ///< Position that the tracked pointer touched, mm.
  Point<frames::Ct> ct;                ///< Position in the CT, mm.
  double sigma_mm = 1;                 ///< Standard deviation of ct − T·reference per axis, > 0.
};

/// Residual of one pair.
struct LandmarkResidual {
  std::string name;
  double distance_mm;  ///< |T·reference − ct| in the fit that used the pair.
  /// |T·reference − ct| in the fit without the pair; NaN if the other pairs do not determine a pose
  /// (three pairs in all, or a collinear rest).
  double leave_one_out_mm;
};

/// A weighted rigid fit with its residuals and uncertainty. The residuals (FRE) say nothing about
/// the error at the target; show tre_rms_mm() there.
struct LandmarkRegistration {
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  std::vector<LandmarkResidual> residuals{};  ///< In the order of the pairs.
  double fre_rms_mm = 0;                      ///< Root mean square of the distances, unweighted.
  /// Localisation error per axis estimated from the residuals, in units of the given sigmas: sqrt(Σ
  /// (d/σ)² / (3N − 6)). Near 1 if the sigmas are realistic.
  double sigma_scale = 0;
  /// Estimated 3D localisation error (FLE) of the pairs, mm RMS: sqrt(3)·sigma_scale·rms(σ).
  double fle_rms_mm = 0;
  /// Uncertainty from the given sigmas (not rescaled by the residuals), about the weighted centroid
  /// in Ct.
  PoseUncertainty uncertainty;

  /// Expected covariance of the error at a point of the CT, mm².
  [[nodiscard]] Eigen::Matrix3d tre_covariance(const Point<frames::Ct>& target) const {
    return uncertainty.tre_covariance(target);
  }
  /// Expected RMS error at a point of the CT, mm (Fitzpatrick, West, Maurer 1998, with weights).
  [[nodiscard]] double tre_rms_mm(const Point<frames::Ct>& target) const {
    return uncertainty.tre_rms_mm(target);
  }
};

/// Makes every check of register_landmarks() that needs no fit: all of them except the check for
/// lists that only a reflection would match.
Result<void> check_landmarks(std::span<const LandmarkPair> pairs);

/// Closed-form weighted least squares (Umeyama 1991 without scale, weights 1/σ², reflections
/// excluded). Rejects fewer than 3 pairs and more than kMostLandmarks, empty or repeated names,
/// points that are not finite or beyond 1e7 mm, a sigma outside 0.001 to 1000 mm, points that are
/// coincident or collinear in either frame, and point sets that only a reflection would match. The
/// message names the pair or the frame. Thread-safe.
Result<LandmarkRegistration> register_landmarks(std::span<const LandmarkPair> pairs);

}  // namespace nav::registration
