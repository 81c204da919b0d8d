// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/matrices.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

namespace nav {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d turn() { return Eigen::AngleAxisd(0.7, Vector3d(1, 2, -1).normalized()).matrix(); }

TEST(MatricesTest, FindsTheEigenpairsOfAKnownMatrix) {
  const Vector3d planted(-2, 0.5, 7);
  const auto found = eigenpairs<3>(turn() * planted.asDiagonal() * turn().transpose());
  EXPECT_LT((found.values - planted).norm(), 1e-13);
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_NEAR(std::abs(found.vectors.col(i).dot(turn().col(i))), 1, 1e-13);
  }
}

TEST(MatricesTest, EigenpairsOfFixedAndDynamicSizesAgree) {
  Eigen::Matrix<double, 6, 6> m;
  for (Eigen::Index i = 0; i < 36; ++i) m(i / 6, i % 6) = std::sin(1.0 + static_cast<double>(i));
  m = (m + m.transpose()).eval();
  const auto fixed = eigenpairs<6>(m);
  EXPECT_LT((eigenpairs<Eigen::Dynamic>(m).values - fixed.values).norm(), 1e-12);
  EXPECT_LT((m * fixed.vectors - fixed.vectors * fixed.values.asDiagonal()).norm(), 1e-12);
}

TEST(MatricesTest, SingularValuesReproduceTheMatrix) {
  Matrix3d m;
  m << 1, 2, 3, -4, 0, 1, 1e-3, 5, -2;
  const SingularValues svd = singular_values(m);
  EXPECT_LT((svd.u * svd.values.asDiagonal() * svd.v.transpose() - m).norm(), 1e-13);
  EXPECT_GE(svd.values[1], svd.values[2]);
}

TEST(MatricesTest, NearestOrthogonalRemovesScaleAndKeepsAReflection) {
  const Matrix3d stretch = Vector3d(1.1, 0.9, 1.05).asDiagonal();
  const Matrix3d mirror = Vector3d(1, 1, -1).asDiagonal();
  EXPECT_LT((nearest_orthogonal(turn() * stretch) - turn()).norm(), 1e-13);
  EXPECT_LT((nearest_orthogonal(turn() * mirror * stretch) - turn() * mirror).norm(), 1e-13);
}

TEST(MatricesTest, ExtentsOfTwoPointsAreZeroAlongOtherAxes) {
  Eigen::Matrix3Xd two(3, 2);
  two << 3, 0, 0, 4, 0, 0;
  EXPECT_LT((extents(two) - Vector3d(4, 3, 0)).norm(), 1e-14);
}

TEST(MatricesTest, RotationBetweenTurnsOneDirectionIntoTheOther) {
  const Vector3d from(0, 0, 2);
  for (const Vector3d& to : {Vector3d(1, 2, 3), Vector3d(0, 0, 1), Vector3d(0, 0, -5)}) {
    const Eigen::Quaterniond q = rotation_between(from, to);
    EXPECT_LT((q * from.normalized() - to.normalized()).norm(), 1e-14) << to.transpose();
    EXPECT_NEAR(q.norm(), 1, 1e-14);
  }
}

TEST(MatricesTest, RigidFitFindsAKnownMotion) {
  Eigen::Matrix3Xd from(3, 4);
  from << 0, 100, 0, 20, 0, 0, 80, 30, 0, 0, 0, 50;
  const Eigen::Matrix3Xd to = (turn() * from).colwise() + Vector3d(5, -6, 7);
  const Eigen::Matrix4d fit = rigid_fit(from, to);
  EXPECT_LT((fit.topLeftCorner<3, 3>() - turn()).norm(), 1e-13);
  EXPECT_LT((fit.topRightCorner<3, 1>() - Vector3d(5, -6, 7)).norm(), 1e-12);
}

TEST(MatricesTest, SymmetricInverseOfASingularMatrixIsNotFinite) {
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  Vector6d values;
  values << 1, 2, 3, 40, 500, 6000;
  Matrix6d m = values.asDiagonal();
  m(0, 5) = m(5, 0) = 20;
  EXPECT_LT((symmetric_inverse(m) * m - Matrix6d::Identity()).norm(), 1e-12);
  EXPECT_LT((symmetric_solve(m, m * values) - values).norm(), 1e-13 * values.norm());
  m.row(2).setZero();
  m.col(2).setZero();
  EXPECT_FALSE(symmetric_inverse(m).allFinite());
  EXPECT_TRUE(symmetric_solve(m, values).allFinite());
}

TEST(MatricesTest, BestRotationIsNoReflectionAndReportsTheReflectionGain) {
  const Matrix3d planted = turn() * Matrix3d(Vector3d(3, 2, 1).asDiagonal());
  EXPECT_LT((best_rotation(planted).rotation - turn()).norm(), 1e-13);
  EXPECT_EQ(best_rotation(planted).reflection_gain, 0);
  const Matrix3d mirrored = turn() * Matrix3d(Vector3d(3, 2, -1).asDiagonal());
  const auto found = best_rotation(mirrored);
  EXPECT_NEAR(found.rotation.determinant(), 1, 1e-13);
  const double gain = (nearest_orthogonal(mirrored).transpose() * mirrored).trace() -
                      (found.rotation.transpose() * mirrored).trace();
  EXPECT_NEAR(found.reflection_gain, gain, 1e-13);
}

TEST(MatricesTest, EigenvaluesOfANanMatrixAreNotFinite) {
  Matrix3d m = Matrix3d::Identity();
  m(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(eigenpairs<3>(m).values.allFinite());
}

}  // namespace
}  // namespace nav
