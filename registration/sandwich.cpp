// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/sandwich.hpp"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include "registration/pose_solver.hpp"

namespace nav::registration {
namespace {

constexpr double kBlockMm = 20;
// n/(n − 6) is no correction any more when the blocks hardly outnumber the parameters.
constexpr int kMinBlocks = 12;
// A well-conditioned sweep has 0.1; below this a direction rests on noise.
constexpr double kMinCurvatureRatio = 1e-3;

/// Rotations in mm: twist = scale · parameter.
Matrix6d twist_from_scaled() {
  Vector6d diagonal = Vector6d::Ones();
  diagonal.head<3>() /= kRotationScaleMm;
  return diagonal.asDiagonal();
}

Matrix6d true_hessian(const Lc2Cost& cost, const Pose& pose, const Eigen::Vector3d& centre,
                      double step_mm) {
  const Matrix6d scale = twist_from_scaled();
  Matrix6d h;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const Vector6d step = scale.col(i) * step_mm;
    const Vector6d up = cost.terms(moved(pose, centre, step), centre).gradient;
    const Vector6d down = cost.terms(moved(pose, centre, -step), centre).gradient;
    h.col(i) = scale * (up - down) / (2 * step_mm);
  }
  return 0.5 * (h + h.transpose());
}

/// n/(n−6) Σ g_b g_bᵀ in scaled parameters, and n.
std::pair<Matrix6d, int> block_scatter(const Lc2Cost& cost, const Pose& pose,
                                       const Eigen::Vector3d& centre) {
  const CostTerms terms = cost.terms(pose, centre, true);
  std::map<std::array<int, 3>, Vector6d> blocks;
  for (std::size_t i = 0; i < terms.patch_gradients.size(); ++i) {
    const Eigen::Vector3d p =
        (pose * Point<frames::Reference>{cost.patches().patches[i].centre_mm}).mm;
    // Relative to the centre, so that a shift of the CT's origin changes nothing.
    const Eigen::Array3d cell = ((p - centre) / kBlockMm).array().floor();
    const std::array<int, 3> key{static_cast<int>(cell[0]), static_cast<int>(cell[1]),
                                 static_cast<int>(cell[2])};
    const auto [block, fresh] = blocks.try_emplace(key, Vector6d::Zero());
    block->second += twist_from_scaled() * terms.patch_gradients[i];
  }
  Matrix6d scatter = Matrix6d::Zero();
  for (const auto& [key, g] : blocks) scatter += g * g.transpose();
  const int n = static_cast<int>(blocks.size());
  if (n > 6) scatter *= static_cast<double>(n) / (n - 6);
  return {scatter, n};
}

std::string describe(const Vector6d& direction) {
  const bool rotation = direction.head<3>().squaredNorm() > direction.tail<3>().squaredNorm();
  Eigen::Vector3d axis = rotation ? direction.head<3>() : direction.tail<3>();
  axis.normalize();
  std::ostringstream text;
  text << std::fixed << std::setprecision(2) << (rotation ? "rotation about" : "translation along")
       << " Ct (" << axis.x() << ", " << axis.y() << ", " << axis.z() << ")";
  return text.str();
}

}  // namespace

SandwichCovariance sandwich_covariance(const Lc2Cost& cost, const Pose& pose,
                                       const Point<frames::Ct>& centre_ct, double step_mm,
                                       double bias_floor_mm) {
  SandwichCovariance result{{centre_ct, Matrix6d::Zero()}, false, ""};
  const auto [scatter, blocks] = block_scatter(cost, pose, centre_ct.mm);
  std::ostringstream fault;
  if (blocks < kMinBlocks) {
    fault << "expected the patches to spread over at least " << kMinBlocks
          << " cubes of 20 mm, found " << blocks;
    result.fault = fault.str();
    return result;
  }
  const Matrix6d h = true_hessian(cost, pose, centre_ct.mm, step_mm);
  if (!h.allFinite() || !scatter.allFinite()) {
    result.fault = "expected a finite curvature of the cost, found NaN or Inf";
    return result;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(h);
  const double weakest = eigen.eigenvalues()[0];
  const double strongest = eigen.eigenvalues()[5];
  if (!(weakest > kMinCurvatureRatio * strongest) || !(strongest > 0)) {
    fault << "the sweep does not determine the " << describe(eigen.eigenvectors().col(0))
          << ": expected a curvature ratio above " << kMinCurvatureRatio << ", found "
          << (strongest > 0 ? weakest / strongest : weakest);
    result.fault = fault.str();
    return result;
  }
  const Matrix6d inverse = h.inverse();
  Matrix6d sigma = inverse * scatter * inverse;
  sigma += bias_floor_mm * bias_floor_mm * Matrix6d::Identity();
  const Matrix6d scale = twist_from_scaled();
  sigma = scale * sigma * scale;
  result.uncertainty.covariance = 0.5 * (sigma + sigma.transpose());
  result.valid = true;
  return result;
}

}  // namespace nav::registration
