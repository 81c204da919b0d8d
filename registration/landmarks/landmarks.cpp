// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/landmarks/landmarks.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <sstream>

#include "nav/matrices.hpp"
#include "nav/positions.hpp"
#include "registration/twist.hpp"

namespace nav::registration {
namespace {

using Pairs = std::vector<LandmarkPair>;
using Pose = Transform<frames::Ct, frames::Reference>;

// Least ratio of the second to the first singular value of the centred points. Below it, the
// rotation about their line rests on less than 1 mm of lever arm per 100 mm of extent.
constexpr double kMinSpreadRatio = 1e-2;
constexpr double kLeastSpreadMm = 1e-3;

Error reject(const std::string& what, const std::string& expected, const std::string& found) {
  return {ErrorCode::kMalformedData, what + ": expected " + expected + ", found " + found};
}

std::string number(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

Result<void> check_position(const std::string& what, const std::string& frame,
                            const Eigen::Vector3d& p) {
  if (!p.allFinite()) return reject(what, "a finite " + frame + " point in mm", "NaN or Inf");
  if (is_place(p)) return {};
  std::ostringstream found;
  found << p.transpose();
  return reject(what, "a " + frame + " point within 1e7 mm", found.str());
}

Result<void> check_pairs(std::span<const LandmarkPair> pairs) {
  if (pairs.size() < 3) {
    return reject("landmarks", "at least 3 pairs", std::to_string(pairs.size()));
  }
  if (pairs.size() > kMostLandmarks) {
    return reject("landmarks", "at most " + std::to_string(kMostLandmarks) + " pairs",
                  std::to_string(pairs.size()));
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const LandmarkPair& pair = pairs[i];
    if (pair.name.empty()) return reject("landmark " + std::to_string(i), "a name", "none");
    const std::string what = "landmark '" + pair.name + "'";
    if (!names.insert(pair.name).second) return reject(what, "a unique name", "it twice");
    if (auto ok = check_position(what, "Reference", pair.reference.mm); !ok) return ok;
    if (auto ok = check_position(what, "Ct", pair.ct.mm); !ok) return ok;
    if (!(pair.sigma_mm >= kLeastSigmaMm && pair.sigma_mm <= kGreatestSigmaMm)) {
      return reject(what, "a sigma of 0.001 to 1000 mm", number(pair.sigma_mm));
    }
  }
  return {};
}

/// Describes a degenerate spread of a point set; empty if the spread is sufficient.
std::optional<std::string> spread_defect(const Eigen::Matrix3Xd& points) {
  const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
  const Eigen::Vector3d s = extents(centred);
  if (s[0] < kLeastSpreadMm) return "coincident points";
  if (s[1] < kMinSpreadRatio * s[0]) {
    return "collinear points (singular value ratio " + number(s[1] / s[0]) + ")";
  }
  return {};
}

struct PointSets {
  Eigen::Matrix3Xd reference, ct;
  Eigen::VectorXd weights;  ///< 1/σ².
};

PointSets point_sets(const Pairs& pairs) {
  const auto n = static_cast<Eigen::Index>(pairs.size());
  PointSets sets{Eigen::Matrix3Xd(3, n), Eigen::Matrix3Xd(3, n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const LandmarkPair& pair = pairs[static_cast<std::size_t>(i)];
    sets.reference.col(i) = pair.reference.mm;
    sets.ct.col(i) = pair.ct.mm;
    sets.weights[i] = 1.0 / (pair.sigma_mm * pair.sigma_mm);
  }
  return sets;
}

struct Fit {
  Pose pose;
  double chi2;            ///< Σ d²/σ² for the rotation found.
  double reflected_chi2;  ///< Σ d²/σ² if reflections were allowed; equal if no reflection helps.
};

/// Umeyama (1991), equations 40 to 43 with c = 1 and weights.
Fit fit(const PointSets& sets) {
  const double total = sets.weights.sum();
  const Eigen::Vector3d reference_mean = sets.reference * sets.weights / total;
  const Eigen::Vector3d ct_mean = sets.ct * sets.weights / total;
  const Eigen::Matrix3Xd a = sets.reference.colwise() - reference_mean;
  const Eigen::Matrix3Xd b = sets.ct.colwise() - ct_mean;
  const Eigen::Matrix3d covariance = b * sets.weights.asDiagonal() * a.transpose();
  const auto [r, reflection_gain] = best_rotation(covariance);
  const Eigen::Quaterniond q = Eigen::Quaterniond(r).normalized();
  const Pose pose(q, ct_mean - q * reference_mean);
  const Eigen::Matrix3Xd rest = b - r * a;
  const double chi2 = rest.colwise().squaredNorm() * sets.weights;
  return {pose, chi2, std::max(chi2 - 2 * reflection_gain, 0.0)};
}

double distance_mm(const Pose& pose, const LandmarkPair& pair) {
  return ((pose * pair.reference).mm - pair.ct.mm).norm();
}

/// Distance of a pair from the fit of the others; NaN if they do not determine one.
double leave_one_out_mm(const Pairs& pairs, std::size_t left_out) {
  Pairs rest = pairs;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(left_out));
  if (rest.size() < 3) return std::numeric_limits<double>::quiet_NaN();
  const PointSets sets = point_sets(rest);
  if (spread_defect(sets.reference) || spread_defect(sets.ct)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return distance_mm(fit(sets).pose, pairs[left_out]);
}

/// (Σ JᵀJ/σ²)⁻¹ about the weighted centroid, where the matrix is block-diagonal.
PoseUncertainty uncertainty_of(const PointSets& sets, const Pose& pose) {
  const double total = sets.weights.sum();
  const Point<frames::Reference> mean{sets.reference * sets.weights / total};
  PoseUncertainty result{pose * mean, Matrix6d::Zero()};
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < sets.weights.size(); ++i) {
    const Eigen::Matrix3d k = cross_matrix(
        (pose * Point<frames::Reference>{sets.reference.col(i)}).mm - result.centre_ct.mm);
    information += sets.weights[i] * k.transpose() * k;
  }
  result.covariance.topLeftCorner<3, 3>() = information.inverse();
  result.covariance.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() / total;
  return result;
}

}  // namespace

Result<void> check_landmarks(std::span<const LandmarkPair> pairs) {
  if (auto ok = check_pairs(pairs); !ok) return ok;
  const PointSets sets = point_sets(Pairs(pairs.begin(), pairs.end()));
  const std::string well_spread = "points that span a plane";
  if (const auto defect = spread_defect(sets.reference)) {
    return reject("landmarks in Reference", well_spread, *defect);
  }
  if (const auto defect = spread_defect(sets.ct)) {
    return reject("landmarks in Ct", well_spread, *defect);
  }
  return {};
}

Result<LandmarkRegistration> register_landmarks(std::span<const LandmarkPair> pairs) {
  if (const auto ok = check_landmarks(pairs); !ok) return ok.error();
  const Pairs list(pairs.begin(), pairs.end());
  const PointSets sets = point_sets(list);
  const Fit found = fit(sets);
  const auto count = static_cast<double>(list.size());
  const double degrees_of_freedom = 3 * count - 6;
  // A mirrored list (a flipped axis) fits badly, and much better once it is reflected. Five times
  // the stated sigmas cannot be chance; near-planar sets with realistic noise never come close.
  constexpr double kMirrorSigmas = 5;
  if (found.chi2 > kMirrorSigmas * kMirrorSigmas * degrees_of_freedom &&
      found.reflected_chi2 < 0.25 * found.chi2) {
    return reject("landmarks", "a rotation to map Reference to Ct",
                  "a reflection: one list is mirrored");
  }
  LandmarkRegistration result{.ct_from_reference = found.pose,
                              .uncertainty = uncertainty_of(sets, found.pose)};
  double sum2 = 0;
  double sigma2 = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const double d = distance_mm(found.pose, list[i]);
    result.residuals.push_back({list[i].name, d, leave_one_out_mm(list, i)});
    sum2 += d * d;
    sigma2 += list[i].sigma_mm * list[i].sigma_mm;
  }
  result.fre_rms_mm = std::sqrt(sum2 / count);
  result.sigma_scale = std::sqrt(found.chi2 / degrees_of_freedom);
  result.fle_rms_mm = std::sqrt(3 * sigma2 / count) * result.sigma_scale;
  return result;
}

}  // namespace nav::registration
