// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

/// Decompositions of small matrices by Eigen, compiled once for all who need one: a file that uses
/// Eigen's own takes ten seconds longer to compile. None allocates for fixed sizes, each may be
/// called from any thread, and NaN or Inf in the argument comes out as NaN or Inf.
namespace nav {

/// Of a symmetric matrix, of which only the lower triangle is read.
template <int N>
struct Eigenpairs {
  Eigen::Matrix<double, N, 1> values;   ///< Ascending.
  Eigen::Matrix<double, N, N> vectors;  ///< Columns of length 1, in the order of the values.
};

/// For N = 3, 6 and Eigen::Dynamic.
template <int N>
Eigenpairs<N> eigenpairs(const Eigen::Matrix<double, N, N>& symmetric);

/// m = u · values · vᵀ; values descending, not negative; u and v orthogonal, perhaps reflections.
struct SingularValues {
  Eigen::Matrix3d u;
  Eigen::Vector3d values;
  Eigen::Matrix3d v;
};
SingularValues singular_values(const Eigen::Matrix3d& m);

/// Inverse of a symmetric matrix by LDLᵀ; infinite where a pivot is 0.
Eigen::Matrix<double, 6, 6> symmetric_inverse(const Eigen::Matrix<double, 6, 6>& m);
/// x with m x = b, m symmetric, by LDLᵀ; what a pivot of 0 leaves free is 0.
Eigen::Matrix<double, 6, 1> symmetric_solve(const Eigen::Matrix<double, 6, 6>& m,
                                            const Eigen::Matrix<double, 6, 1>& b);

/// Extents of points in columns about the origin: singular values, descending, 0 where there are
/// fewer than three points.
Eigen::Vector3d extents(const Eigen::Matrix3Xd& points);

/// Orthogonal matrix nearest to m in Frobenius' norm; a reflection when m is one.
Eigen::Matrix3d nearest_orthogonal(const Eigen::Matrix3d& m);

/// Rotation R with the greatest trace of Rᵀm (Umeyama 1991, equation 40). m must not be NaN.
struct BestRotation {
  Eigen::Matrix3d rotation;
  /// By how much a reflection's trace would be greater; 0 where none would be.
  double reflection_gain;
};
BestRotation best_rotation(const Eigen::Matrix3d& m);

/// Shortest rotation from one direction to another, neither zero; about some axis at right angles
/// when they are opposite.
Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Rotation and translation with the least sum of squares |to − T from|² over columns (Umeyama
/// 1991, with c = 1). At least three points that are not on a line determine it.
Eigen::Matrix4d rigid_fit(const Eigen::Ref<const Eigen::Matrix3Xd>& from,
                          const Eigen::Ref<const Eigen::Matrix3Xd>& to);

}  // namespace nav
