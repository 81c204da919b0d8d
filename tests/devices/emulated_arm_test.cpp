// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/emulated_arm.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <random>

#include "tests/devices/can_arm_models.hpp"
#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

constexpr double kMm = 2e-3, kRad = 2e-6;

Eigen::Matrix4d pose_of(const Eigen::Quaterniond& turn, const Eigen::Vector3d& at_mm) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = turn.normalized().toRotationMatrix();
  pose.translation() = at_mm;
  return pose.matrix();
}

/// Largest distance of two poses: mm, rad.
std::pair<double, double> apart(const Eigen::Matrix4d& a, const Eigen::Matrix4d& b) {
  const Eigen::Matrix3d turn = a.topLeftCorner<3, 3>().transpose() * b.topLeftCorner<3, 3>();
  return {(a - b).topRightCorner<3, 1>().norm(), Eigen::AngleAxisd(turn).angle()};
}

/// A pose as a tracker sees it: more than a metre away, turned anyhow.
const Eigen::Matrix4d kSeen = pose_of({0.3, -0.5, 0.7, 0.1}, {-110, 52, -1204});

TEST(EmulatedArmTest, IsAValidArmThatHoldsTheFirstPose) {
  const ArmModel arm = emulated_arm(kSeen);
  ASSERT_TRUE(test::has_value(validate(arm)));
  const auto [mm, rad] = apart(arm_pose(arm, emulated_arm_start_rad()).base_from_body, kSeen);
  EXPECT_LT(mm, 1e-9);
  EXPECT_LT(rad, 1e-7);
}

TEST(EmulatedArmTest, FollowsAHandAroundTheFirstPose) {
  const ArmModel arm = emulated_arm(kSeen);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d axis =
        Eigen::Vector3d(share(random), share(random), share(random)).normalized();
    const Eigen::Vector3d way(120 * share(random), 120 * share(random), 120 * share(random));
    const Eigen::Matrix4d wanted =
        pose_of(Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * share(random), axis)) *
                    Eigen::Quaterniond(Eigen::Matrix3d(kSeen.topLeftCorner<3, 3>())),
                kSeen.topRightCorner<3, 1>() + way);
    const auto angles = angles_at_pose(arm, wanted, emulated_arm_start_rad());
    ASSERT_TRUE(angles) << i;
    const auto [mm, rad] = apart(arm_pose(arm, *angles).base_from_body, wanted);
    EXPECT_LT(mm, kMm);
    EXPECT_LT(rad, kRad);
  }
}

TEST(EmulatedArmTest, AnglesOfAnotherArmAreFoundAgain) {
  const ArmModel arm = six_joint_arm();
  const std::vector<double> planted{0.3, 0.5, -0.7, 0.2, 0.4, -0.1};
  std::vector<double> start = planted;
  for (double& angle : start) angle += 0.1;
  const auto found = angles_at_pose(arm, arm_pose(arm, planted).base_from_body, start);
  ASSERT_TRUE(found);
  for (std::size_t i = 0; i < planted.size(); ++i) EXPECT_NEAR((*found)[i], planted[i], 1e-4);
}

TEST(EmulatedArmTest, APoseBeyondItsLinksIsNotReached) {
  const ArmModel arm = emulated_arm(kSeen);
  Eigen::Matrix4d far = kSeen;
  far(0, 3) += 3000;
  EXPECT_FALSE(angles_at_pose(arm, far, emulated_arm_start_rad()));
  far(0, 3) = std::nan("");
  EXPECT_FALSE(angles_at_pose(arm, far, emulated_arm_start_rad()));
}

}  // namespace
}  // namespace nav::devices
