// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/matrices.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace nav {

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

Eigen::Vector3d extents(const Eigen::Matrix3Xd& points) {
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  const auto values = Eigen::JacobiSVD<Eigen::Matrix3Xd>(points).singularValues().eval();
  out.head(values.size()) = values;
  return out;
}

Eigen::Matrix3d nearest_orthogonal(const Eigen::Matrix3d& m) {
  const SingularValues svd = singular_values(m);
  return svd.u * svd.v.transpose();
}

Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

Eigen::Matrix4d rigid_fit(const Eigen::Ref<const Eigen::Matrix3Xd>& from,
                          const Eigen::Ref<const Eigen::Matrix3Xd>& to) {
  return Eigen::umeyama(from, to, false);
}

}  // namespace nav
