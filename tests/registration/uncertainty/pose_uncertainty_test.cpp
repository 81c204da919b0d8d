// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/uncertainty/pose_uncertainty.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "nav/check.hpp"

namespace nav::registration {
namespace {

constexpr double kRoundingMm = 1e-12;

TEST(PoseUncertaintyTest, WideningAddsAnEqualErrorToEveryPointInEveryDirection) {
  // Correlated rotation and translation errors, so that every point has a different error.
  Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Identity();
  for (int i = 0; i < 6; ++i) root.row(i) *= i < 3 ? 0.01 * (i + 1) : 0.2 * i;
  root.bottomLeftCorner<3, 3>().setConstant(0.1);
  const PoseUncertainty narrow{{{10, -20, 30}}, root * root.transpose()};
  PoseUncertainty wide = narrow;
  constexpr double kRmsMm = 1.5;
  wide.widen(kRmsMm);
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(10, -20, 30), Eigen::Vector3d(90, 40, -60)}) {
    const Eigen::Matrix3d added = wide.tre_covariance({at}) - narrow.tre_covariance({at});
    EXPECT_TRUE(added.isApprox(kRmsMm * kRmsMm / 3 * Eigen::Matrix3d::Identity(), kRoundingMm))
        << added;
    EXPECT_NEAR(wide.tre_rms_mm({at}), std::hypot(narrow.tre_rms_mm({at}), kRmsMm), kRoundingMm);
  }
}

TEST(PoseUncertaintyTest, WideningByANegativeErrorIsABug) {
  PoseUncertainty one{{{0, 0, 0}}, Eigen::Matrix<double, 6, 6>::Identity()};
  EXPECT_THROW(one.widen(-1), Bug);
  EXPECT_EQ(one.covariance, (Eigen::Matrix<double, 6, 6>::Identity()));
}

TEST(PoseUncertaintyTest, WideningByNanGivesANanError) {
  PoseUncertainty one{{{0, 0, 0}}, Eigen::Matrix<double, 6, 6>::Identity()};
  one.widen(std::nan(""));
  EXPECT_TRUE(std::isnan(one.tre_rms_mm({{1, 2, 3}})));
}

}  // namespace
}  // namespace nav::registration
