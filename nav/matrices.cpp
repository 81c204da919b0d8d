// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/matrices.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "nav/check.hpp"

namespace nav {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// Length of the sum of two unit vectors below which half of its digits are lost.
constexpr double kNearlyOpposite = 1e-8;

}  // namespace

template <int N>
Eigenpairs<N> eigenpairs(const Eigen::Matrix<double, N, N>& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template Eigenpairs<3> eigenpairs(const Eigen::Matrix3d&);
template Eigenpairs<6> eigenpairs(const Eigen::Matrix<double, 6, 6>&);
template Eigenpairs<Eigen::Dynamic> eigenpairs(const Eigen::MatrixXd&);

SingularValues singular_values(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Matrix6d symmetric_inverse(const Matrix6d& m) {
  const auto factors = m.ldlt();
  // For such a pivot solve() returns 0 as undetermined value, which as a covariance would claim
  // certainty.
  if ((factors.vectorD().array() == 0).any()) {
    return Matrix6d::Constant(std::numeric_limits<double>::infinity());
  }
  return factors.solve(Matrix6d::Identity());
}

Vector6d symmetric_solve(const Matrix6d& m, const Vector6d& b) { return m.ldlt().solve(b); }

Eigen::Vector3d extents(const Eigen::Matrix3Xd& points) {
  // Squaring loses half of the digits. The axes of the squares are accurate enough, so the extents
  // are measured along them.
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const auto& p : points.colwise()) squares += p * p.transpose();
  const Eigen::Matrix3d axes = eigenpairs<3>(squares).vectors;
  Eigen::Vector3d sums = Eigen::Vector3d::Zero();
  for (const auto& p : points.colwise()) sums += (axes.transpose() * p).cwiseAbs2();
  Eigen::Vector3d out = sums.cwiseSqrt();
  std::sort(out.data(), out.data() + 3, std::greater<>());
  return out;
}

Eigen::Matrix3d nearest_orthogonal(const Eigen::Matrix3d& m) {
  const SingularValues svd = singular_values(m);
  return svd.u * svd.v.transpose();
}

BestRotation best_rotation(const Eigen::Matrix3d& m) {
  const SingularValues svd = singular_values(m);
  Eigen::Vector3d sign(1, 1, 1);
  if ((svd.u * svd.v.transpose()).determinant() < 0) sign[2] = -1;
  return {svd.u * sign.asDiagonal() * svd.v.transpose(), sign[2] < 0 ? 2 * svd.values[2] : 0.0};
}

Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized();
  const Eigen::Vector3d b = to.normalized();
  const double twice_w = (a + b).norm();
  Eigen::Quaterniond q;
  if (twice_w < kNearlyOpposite) {
    q.coeffs() << a.unitOrthogonal(), 0;
  } else {
    q.coeffs() << a.cross(b) / twice_w, 0.5 * twice_w;
  }
  return q.normalized();
}

Eigen::Matrix4d rigid_fit(const Eigen::Ref<const Eigen::Matrix3Xd>& from,
                          const Eigen::Ref<const Eigen::Matrix3Xd>& to) {
  NAV_CHECK(from.cols() == to.cols() && from.cols() > 0, from.cols(), to.cols());
  const auto mean = [](const Eigen::Ref<const Eigen::Matrix3Xd>& points) {
    return Eigen::Vector3d(points.rowwise().mean());
  };
  const Eigen::Vector3d from_mean = mean(from);
  const Eigen::Vector3d to_mean = mean(to);
  Eigen::Matrix3d together = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < from.cols(); ++i) {
    together += (to.col(i) - to_mean) * (from.col(i) - from_mean).transpose();
  }
  Eigen::Matrix4d out = Eigen::Matrix4d::Identity();
  out.topLeftCorner<3, 3>() = best_rotation(together).rotation;
  out.topRightCorner<3, 1>() = to_mean - out.topLeftCorner<3, 3>() * from_mean;
  return out;
}

}  // namespace nav
