// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/shape_strain.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

namespace nav::registration {
namespace {

// Points closer than this share the errors of the segmentation and of the pointer.
constexpr double kSharedErrorMm = 5;
constexpr double kStrainNeighbourMm = 8;
constexpr double kLeastNeighbours = 20;
constexpr double kMostSigmas = 3;
constexpr double kHuberWidth = 1.345;
constexpr double kUsualStrain = 0.1;
// If the pose takes up all but this fraction of the squares of an explanation, the rest is within
// the errors of the field between its nodes.
constexpr double kLeastVisible = 0.02;

using Cube = std::array<int, 3>;

Cube cube_of(const Eigen::Vector3d& p, double side_mm) {
  const Eigen::Array3d at = (p / side_mm).array().floor();
  return {static_cast<int>(at[0]), static_cast<int>(at[1]), static_cast<int>(at[2])};
}

std::map<Cube, std::vector<std::size_t>> cubes_of(const std::vector<Eigen::Vector3d>& places,
                                                  double side_mm) {
  std::map<Cube, std::vector<std::size_t>> cubes;
  for (std::size_t k = 0; k < places.size(); ++k) cubes[cube_of(places[k], side_mm)].push_back(k);
  return cubes;
}

/// Standard deviation of what a point and its nearest neighbour do not share.
std::optional<double> roughness_mm(const ShapeCurvature& at, double sigma_mm) {
  const auto cubes = cubes_of(at.places_ct_mm, kStrainNeighbourMm);
  double squares = 0;
  double count = 0;
  for (std::size_t i = 0; i < at.places_ct_mm.size(); ++i) {
    const Eigen::Vector3d& p = at.places_ct_mm[i];
    const Cube cube = cube_of(p, kStrainNeighbourMm);
    double least = kStrainNeighbourMm;
    std::optional<std::size_t> nearest;
    for (int n = 0; n < 27; ++n) {
      const auto found =
          cubes.find({cube[0] + n % 3 - 1, cube[1] + n / 3 % 3 - 1, cube[2] + n / 9 - 1});
      if (found == cubes.end()) continue;
      for (const std::size_t j : found->second) {
        const double apart = (at.places_ct_mm[j] - p).norm();
        if (j == i || apart >= least) continue;
        least = apart;
        nearest = j;
      }
    }
    if (!nearest) continue;
    const double difference2 = (at.offsets_mm[i] - at.offsets_mm[*nearest]).squaredNorm() / 2;
    squares += std::min(difference2, std::pow(kMostSigmas * sigma_mm, 2));
    ++count;
  }
  if (count < kLeastNeighbours) return {};
  return std::sqrt(squares / count);
}

/// Columns: twist, shared distance, six strains.
using Columns = Eigen::Matrix<double, 3, 13>;
using Normal = Eigen::Matrix<double, 13, 13>;

/// Motion of a point by the parameters, without the shared distance.
Columns motion_of(const Eigen::Vector3d& arm) {
  Columns motion = Columns::Zero();
  motion.leftCols<3>() = -cross_matrix(arm);
  motion.middleCols<3>(3).setIdentity();
  // Strains xx, yy, zz, yz, zx, xy; the off-diagonal ones scaled so that all have one norm.
  const double half = std::sqrt(0.5);
  for (Eigen::Index i = 0; i < 3; ++i) {
    motion(i, 7 + i) = arm[i];
    const Eigen::Index j = (i + 1) % 3;
    const Eigen::Index k = (i + 2) % 3;
    motion(j, 10 + i) = half * arm[k];
    motion(k, 10 + i) = half * arm[j];
  }
  return motion;
}

Columns columns_of(const ShapeSample& sample, ShapeKind kind, const Eigen::Vector3d& arm) {
  Columns motion = motion_of(arm);
  if (kind == ShapeKind::kSurface) motion.col(6) = -sample.axis;
  return sample.by_point * motion;
}

Eigen::Matrix3d strain_of(const Eigen::Matrix<double, 6, 1>& s) {
  const double half = std::sqrt(0.5);
  Eigen::Matrix3d strain = s.head<3>().asDiagonal();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Index j = (i + 1) % 3;
    const Eigen::Index k = (i + 2) % 3;
    strain(j, k) = strain(k, j) = half * s[3 + i];
  }
  return strain;
}

}  // namespace

ShapeNoise shape_noise(const ShapeCurvature& at, double discrepancy_mm, double least_mm) {
  ShapeNoise noise{.sigma_mm = 0, .rough_mm = {}, .independent_points = 1};
  std::vector<double> sizes;
  for (const Eigen::Vector3d& one : at.offsets_mm) sizes.push_back(one.norm());
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  double squares = 0;
  for (const double size : sizes) squares += std::pow(std::min(size, 5 * *middle), 2);
  // The larger one: the tails of a wrong shape count, single strays do not.
  noise.sigma_mm = std::max(
      {1.4826 * *middle, std::sqrt(squares / static_cast<double>(sizes.size())), least_mm});
  noise.rough_mm = roughness_mm(at, noise.sigma_mm);
  const auto count = static_cast<double>(at.places_ct_mm.size());
  const auto cells = static_cast<double>(cubes_of(at.places_ct_mm, kSharedErrorMm).size());
  const auto blocks = static_cast<double>(cubes_of(at.places_ct_mm, 15).size());
  const double rough2 = std::pow(noise.rough_mm.value_or(noise.sigma_mm) / noise.sigma_mm, 2);
  const double shared2 = std::pow(discrepancy_mm / noise.sigma_mm, 2);
  const double share = std::clamp(std::max(shared2, 1 - rough2), 0.0, 1.0);
  const double members = cells / blocks;
  noise.independent_points = std::min(count, cells) / (1 + (members - 1) * share);
  return noise;
}

ShapeStrain shape_strain(const ReferencePoints& points, const ShapeField& shape,
                         const Transform<frames::Ct, frames::Reference>& pose,
                         const ShapeCurvature& at, const ShapeNoise& noise) {
  Normal normal = Normal::Zero();
  Eigen::Matrix<double, 13, 1> gradient = Eigen::Matrix<double, 13, 1>::Zero();
  const double width = kHuberWidth * noise.sigma_mm;
  for (const std::size_t i : at.counted) {
    const Eigen::Vector3d p = (pose * points[i]).mm;
    const ShapeSample sample = shape.at(p);
    const Columns j = columns_of(sample, shape.kind(), p - at.centre_ct_mm);
    const double weight = std::min(1.0, width / std::max(sample.offset_mm.norm(), 1e-12));
    normal += weight * j.transpose() * j;
    gradient -= weight * j.transpose() * sample.offset_mm;
  }
  const double information = noise.independent_points / static_cast<double>(at.counted.size()) /
                             (noise.sigma_mm * noise.sigma_mm);
  normal *= information;
  gradient *= information;
  ShapeStrain out{.stretches = Eigen::Vector3d::Zero(),
                  .longest_ct = Eigen::Vector3d::UnitX(),
                  .moved_mm = 0,
                  .moved_sigma_mm = std::numeric_limits<double>::infinity(),
                  .evidence = 0,
                  .scale = 0,
                  .scale_sigma = std::numeric_limits<double>::infinity(),
                  .shared_mm = 0,
                  .shared_sigma_mm = std::numeric_limits<double>::infinity()};
  const Matrix6d rigid = normal.topLeftCorner<6, 6>();
  const Eigen::LDLT<Matrix6d> pose_solver(rigid);
  const Vector6d settle = pose_solver.solve(gradient.head<6>());
  const double by_pose = 0.5 * gradient.head<6>().dot(settle);
  // One more column beside the pose: its best value and standard error.
  const auto alone = [&](const Eigen::Matrix<double, 13, 1>& column, double& value, double& sigma) {
    const Eigen::Matrix<double, 13, 1> product = normal * column;
    const double whole = column.dot(product);
    const Vector6d shared = product.head<6>();
    const double visible = whole - shared.dot(pose_solver.solve(shared));
    if (!(visible > kLeastVisible * whole && whole > 0)) return;
    value = (column.dot(gradient) - shared.dot(settle)) / visible;
    sigma = 1 / std::sqrt(visible);
  };
  Eigen::Matrix<double, 13, 1> column = Eigen::Matrix<double, 13, 1>::Unit(6);
  alone(column, out.shared_mm, out.shared_sigma_mm);
  column.setZero();
  column.segment<3>(7).setOnes();
  alone(column, out.scale, out.scale_sigma);
  // Twist and strains.
  Eigen::Matrix<double, 12, 12> both;
  both << rigid, normal.block<6, 6>(0, 7), normal.block<6, 6>(7, 0), normal.block<6, 6>(7, 7);
  both.diagonal().tail<6>().array() += 1 / (kUsualStrain * kUsualStrain);
  Eigen::Matrix<double, 12, 1> g;
  g << gradient.head<6>(), gradient.tail<6>();
  const Eigen::LDLT<Eigen::Matrix<double, 12, 12>> solver(both);
  const Eigen::Matrix<double, 12, 1> x = solver.solve(g);
  if (!x.allFinite()) return out;
  const Eigen::Matrix<double, 12, 12> covariance =
      solver.solve(Eigen::Matrix<double, 12, 12>::Identity());
  out.evidence = 0.5 * g.dot(x) - by_pose;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(strain_of(x.tail<6>()));
  out.stretches = principal.eigenvalues();
  Eigen::Index longest = 0;
  out.stretches.cwiseAbs().maxCoeff(&longest);
  out.longest_ct = principal.eigenvectors().col(longest);
  double moved2 = 0;
  double variance = 0;
  for (const std::size_t i : at.counted) {
    const Columns motion = motion_of((pose * points[i]).mm - at.centre_ct_mm);
    Eigen::Matrix<double, 3, 12> both_motions;
    both_motions << motion.leftCols<6>(), motion.rightCols<6>();
    moved2 += (both_motions * x).squaredNorm();
    variance += (both_motions * covariance * both_motions.transpose()).trace();
  }
  out.moved_mm = std::sqrt(moved2 / static_cast<double>(at.counted.size()));
  out.moved_sigma_mm = std::sqrt(variance / static_cast<double>(at.counted.size()));
  return out;
}

}  // namespace nav::registration
