// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/uncertainty/joint_uncertainty.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "nav/index.hpp"
#include "registration/uncertainty/misfit_causes.hpp"

namespace nav::registration {
namespace {

constexpr Eigen::Index kPoseRows = 6;

/// Scaled parameters [60 ω | t] of the pose that move a patch as the errors do, for each error that
/// is estimated, in units of its standard deviation.
using ByError = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Share of the squared step to the joint minimum that is not chance, [0, 1): 1 − k/χ² for the
/// slope by k errors that is left once the pose follows them, with its scatter (James and Stein
/// 1961).
double share_beyond_chance(const Eigen::MatrixXd& curvature, const Eigen::MatrixXd& scatter,
                           const Eigen::VectorXd& slope) {
  const Eigen::Index count = slope.size() - kPoseRows;
  Eigen::MatrixXd reduce(count, slope.size());  // The pose follows the errors.
  reduce.leftCols(kPoseRows) = -curvature.topLeftCorner(kPoseRows, kPoseRows)
                                    .ldlt()
                                    .solve(curvature.topRightCorner(kPoseRows, count))
                                    .transpose();
  reduce.rightCols(count).setIdentity();
  const Eigen::VectorXd left = reduce * slope;
  const Eigen::MatrixXd noise = reduce * scatter * reduce.transpose();
  const double chi2 = left.dot(noise.ldlt().solve(left));
  const auto k = static_cast<double>(count);
  return chi2 <= k ? 0 : 1 - k / chi2;  // NaN spreads, and is rejected.
}

}  // namespace

JointCovariance joint_covariance(const LocalShape& shape, const PatchSet& as_recorded,
                                 const ImageErrors& errors, const Pose& pose,
                                 const ErrorSigmas& sigmas, std::span<const ImageMotion> motions,
                                 ProbePath path, double bias_floor_mm) {
  const PatchSet patches = corrected(as_recorded, errors, motions, path);
  JointCovariance out{sandwich_covariance(shape, patches, pose, bias_floor_mm)};
  if (!out.pose.valid || shape.patch_hessians.empty()) return out;
  const ErrorVector sigma = sigmas.vector();
  std::vector<Eigen::Index> estimated;
  for (Eigen::Index i = 0; i < kErrorParameters; ++i) {
    if (sigma[i] > 0) estimated.push_back(i);
  }
  const auto count = static_cast<Eigen::Index>(estimated.size());
  if (count == 0) return out;
  const Eigen::Index all = kPoseRows + count;

  const Witnesses witnesses = witnesses_of(shape, patches, pose, motions);
  const auto twists = twists_by_errors(as_recorded, errors, motions, path);
  const ErrorVector values = errors.vector();
  Eigen::MatrixXd curvature = Eigen::MatrixXd::Zero(all, all);
  curvature.topLeftCorner<kPoseRows, kPoseRows>() = shape.hessian;
  std::map<std::array<int, 3>, Eigen::VectorXd> clusters;
  for (std::size_t i = 0; i < witnesses.all.size(); ++i) {
    const Witness& witness = witnesses.all[i];
    ByError by(6, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Vector6d twist = sigma[estimated[as_size(static_cast<int>(k))]] *
                             twists[i].col(estimated[as_size(static_cast<int>(k))]);
      const Eigen::Vector3d turn = witnesses.rotation * twist.head<3>();
      by.col(k).head<3>() = kRotationScaleMm * turn;
      by.col(k).tail<3>() =
          witnesses.rotation * twist.tail<3>() + cross_matrix(witness.from_centre) * turn;
    }
    const ByError curved = witness.hessian * by;
    curvature.topRightCorner(kPoseRows, count) += curved;
    curvature.bottomRightCorner(count, count) += by.transpose() * curved;
    auto [at, fresh] = clusters.try_emplace(witness.cube);
    if (fresh) at->second.setZero(all);
    at->second.head<kPoseRows>() += witness.gradient;
    at->second.tail(count) += by.transpose() * witness.gradient;
  }
  curvature.bottomLeftCorner(count, kPoseRows) =
      curvature.topRightCorner(kPoseRows, count).transpose();
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(all, all);
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(all);
  for (const auto& [cube, gradient] : clusters) {
    scatter += gradient * gradient.transpose();
    slope += gradient;
  }
  const auto n = static_cast<double>(clusters.size());
  scatter *= n / std::max(n - static_cast<double>(all), 0.5 * n);

  const Eigen::LDLT<Matrix6d> pose_only(shape.hessian);
  const double weight = std::max(
      pose_only.solve(scatter.topLeftCorner<kPoseRows, kPoseRows>()).trace() / kPoseRows, 0.0);
  Eigen::VectorXd prior = Eigen::VectorXd::Zero(all);
  prior.tail(count).setConstant(weight);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index i = estimated[as_size(static_cast<int>(k))];
    slope[kPoseRows + k] += weight * values[i] / sigma[i];
  }
  const double beyond_chance = share_beyond_chance(curvature, scatter, slope);
  curvature += Eigen::MatrixXd(prior.asDiagonal());
  const Eigen::LDLT<Eigen::MatrixXd> solver(curvature);
  const Eigen::MatrixXd inner = scatter + Eigen::MatrixXd((weight * prior).asDiagonal());
  const Eigen::MatrixXd half = solver.solve(inner);
  Eigen::MatrixXd covariance = solver.solve(half.transpose());
  covariance = 0.5 * (covariance + covariance.transpose()).eval();
  if (solver.info() != Eigen::Success || !solver.isPositive() || !covariance.allFinite()) {
    out.pose.valid = false;
    out.pose.fault = "the sweep does not tell its pose from errors of the system";
    return out;
  }
  const Matrix6d scale = twist_from_scaled();
  const Matrix6d floor = bias_floor_mm * bias_floor_mm * Matrix6d::Identity();
  const Vector6d left = std::sqrt(beyond_chance) * solver.solve(slope).head<kPoseRows>();
  out.pose.uncertainty.covariance =
      scale * (covariance.topLeftCorner<kPoseRows, kPoseRows>() + left * left.transpose() + floor) *
      scale;
  for (Eigen::Index k = 0; k < count; ++k) {
    for (Eigen::Index m = 0; m < count; ++m) {
      const Eigen::Index i = estimated[as_size(static_cast<int>(k))];
      const Eigen::Index j = estimated[as_size(static_cast<int>(m))];
      out.errors(i, j) = sigma[i] * sigma[j] * covariance(kPoseRows + k, kPoseRows + m);
    }
  }
  return out;
}

}  // namespace nav::registration
