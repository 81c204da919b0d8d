// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

/// Decompositions of small matrices by Eigen, compiled once for all callers: a file that includes
/// Eigen's decompositions takes ten seconds longer to compile. None allocates for fixed sizes. All
/// are thread-safe. NaN or Inf in the argument gives NaN or Inf.
namespace nav {

/// Eigenvalues and eigenvectors of a symmetric matrix.
template <int N>
struct Eigenpairs {
  Eigen::Matrix<double, N, 1> values;   ///< Ascending.
  Eigen::Matrix<double, N, N> vectors;  ///< Unit columns, in the order of the values.
};

/// Eigendecomposition for N = 3, 6 and Eigen::Dynamic. Only the lower triangle is read.
template <int N>
Eigenpairs<N> eigenpairs(const Eigen::Matrix<double, N, N>& symmetric);

/// m = u · values · vᵀ; values descending, >= 0; u and v orthogonal, possibly reflections.
struct SingularValues {
  Eigen::Matrix3d u;
  Eigen::Vector3d values;
  Eigen::Matrix3d v;
};
SingularValues singular_values(const Eigen::Matrix3d& m);

/// Inverse of a symmetric matrix by LDLᵀ; infinite where a pivot is 0.
Eigen::Matrix<double, 6, 6> symmetric_inverse(const Eigen::Matrix<double, 6, 6>& m);
/// Solves m x = b by LDLᵀ, m symmetric. Components that a pivot of 0 leaves undetermined are 0.
Eigen::Matrix<double, 6, 1> symmetric_solve(const Eigen::Matrix<double, 6, 6>& m,
                                            const Eigen::Matrix<double, 6, 1>& b);

/// Extents of the columns about the origin: singular values, descending; 0 for directions that
/// fewer than three points leave empty.
Eigen::Vector3d extents(const Eigen::Matrix3Xd& points);

/// Orthogonal matrix nearest to m in the Frobenius norm; a reflection if m is one.
Eigen::Matrix3d nearest_orthogonal(const Eigen::Matrix3d& m);

/// Rotation R with the greatest trace of Rᵀm (Umeyama 1991, equation 40). m must not be NaN.
struct BestRotation {
  Eigen::Matrix3d rotation;
  /// Amount by which a reflection would have a greater trace; 0 if none would.
  double reflection_gain;
};
BestRotation best_rotation(const Eigen::Matrix3d& m);

/// Shortest rotation from one direction to another, neither zero. Opposite directions are rotated
/// about an arbitrary perpendicular axis.
Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Rotation and translation T that minimise the sum of squares |to − T from|² over the columns
/// (Umeyama 1991, with c = 1). At least three points that are not on a line determine it.
Eigen::Matrix4d rigid_fit(const Eigen::Ref<const Eigen::Matrix3Xd>& from,
                          const Eigen::Ref<const Eigen::Matrix3Xd>& to);

}  // namespace nav
