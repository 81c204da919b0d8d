// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/encoder_arm.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <random>

#include "tests/devices/can_arm_models.hpp"
#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(EncoderArmTest, ReadsAnglesFromCounts) {
  ArmJoint joint{.counts_per_turn = 4096, .zero_counts = 4000};
  EXPECT_DOUBLE_EQ(joint_angle_rad(joint, 4000), 0);
  EXPECT_DOUBLE_EQ(joint_angle_rad(joint, 4000 + 1024), kPi / 2) << "beyond one turn";
  EXPECT_DOUBLE_EQ(joint_angle_rad(joint, 928), kPi / 2) << "past the end of the turn";
  EXPECT_DOUBLE_EQ(joint_angle_rad(joint, 3999), -kPi / 2048);
  EXPECT_DOUBLE_EQ(joint_angle_rad(joint, 4000 - 2048), kPi) << "(-pi, pi]";
  joint.reversed = true;
  EXPECT_DOUBLE_EQ(joint_angle_rad(joint, 928), -kPi / 2);
  EXPECT_DOUBLE_EQ(joint_angle_rad(joint, 4000), 0);
  EXPECT_DOUBLE_EQ(joint_angle_rad(joint, 4000 - 2048), kPi);
  for (const bool reversed : {false, true}) {
    joint.reversed = reversed;
    for (std::uint32_t counts = 0; counts < 4096; ++counts) {
      ASSERT_EQ(joint_counts(joint, joint_angle_rad(joint, counts)), counts);
    }
  }
}

/// A plane arm with two links, in closed form.
TEST(EncoderArmTest, PutsTheBodyWhereTheJointsPutIt) {
  ArmModel arm;
  arm.joints = {arm_joint(1, {0, 0, 1}, {0, 0, 0}), arm_joint(2, {0, 0, 1}, {300, 0, 0})};
  arm.last_from_body.topRightCorner<3, 1>() = Eigen::Vector3d(200, 0, 0);
  const double a = 0.3, b = -0.9;
  const ArmPose pose = arm_pose(arm, std::vector<double>{a, b});
  EXPECT_NEAR(pose.base_from_body(0, 3), 300 * std::cos(a) + 200 * std::cos(a + b), 1e-9);
  EXPECT_NEAR(pose.base_from_body(1, 3), 300 * std::sin(a) + 200 * std::sin(a + b), 1e-9);
  EXPECT_NEAR(pose.base_from_body(0, 0), std::cos(a + b), 1e-12);
}

/// The stated error is what errors of the zeros, of the places and of rounding make of the pose.
TEST(EncoderArmTest, StatesTheErrorThatItsCalibrationLeaves) {
  ArmModel arm = six_joint_arm();
  for (ArmJoint& joint : arm.joints) {
    joint.counts_per_turn = 1U << 13;
    joint.zero_sigma_rad = 3e-4;
    joint.link_sigma_mm = 0.05;
  }
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> angle(-1.2, 1.2);
  for (int posture = 0; posture < 5; ++posture) {
    std::vector<double> angles;
    for (std::size_t i = 0; i < 6; ++i) angles.push_back(angle(random));
    const ArmPose ideal = arm_pose(arm, angles);
    double sum_mm2 = 0;
    constexpr int kRuns = 4000;
    for (int run = 0; run < kRuns; ++run) {
      ArmModel real = arm;
      std::vector<double> read = angles;
      for (std::size_t i = 0; i < 6; ++i) {
        const double step = 2 * kPi / arm.joints[i].counts_per_turn;
        read[i] += step * (std::uniform_real_distribution<double>(-0.5, 0.5)(random)) +
                   arm.joints[i].zero_sigma_rad * normal(random);
        for (int k = 0; k < 3; ++k) {
          real.joints[i].previous_from_joint(k, 3) += arm.joints[i].link_sigma_mm * normal(random);
        }
      }
      const ArmPose moved = arm_pose(real, read);
      sum_mm2 += (moved.base_from_body - ideal.base_from_body).topRightCorner<3, 1>().squaredNorm();
    }
    EXPECT_NEAR(ideal.error_mm, std::sqrt(sum_mm2 / kRuns), 0.05 * ideal.error_mm);
  }
}

TEST(EncoderArmTest, NamesTheJointThatIsOffItsRest) {
  ArmModel arm = six_joint_arm();
  EXPECT_EQ(off_rest(arm, std::vector<double>(6, 2.0)), std::nullopt) << "no rest position";
  arm.rest = ArmRest{std::vector<double>(6, 0.0), 5 * kPi / 180};
  EXPECT_EQ(off_rest(arm, std::vector<double>(6, 0.08)), std::nullopt);
  std::vector<double> angles(6, 0.0);
  angles[5] = kPi / 2;
  const auto said = off_rest(arm, angles);
  ASSERT_TRUE(said);
  EXPECT_NE(said->find("joint 6 (node 7) is at 90 degrees, expected 0 within 5"), std::string::npos)
      << *said;
}

TEST(EncoderArmTest, RejectsWhatCannotBeAnArm) {
  const auto rejects = [](const std::function<void(ArmModel&)>& change, const char* named) {
    ArmModel arm = six_joint_arm();
    arm.rest = ArmRest{std::vector<double>(6, 0.0), 0.1};
    change(arm);
    const auto ok = validate(arm);
    ASSERT_FALSE(ok.has_value()) << named;
    EXPECT_NE(ok.error().message.find(named), std::string::npos) << ok.error().message;
  };
  ArmModel good = six_joint_arm();
  EXPECT_TRUE(validate(good).has_value());
  rejects([](auto& arm) { arm.joints.clear(); }, "joints: expected 1 to 16");
  rejects([](auto& arm) { arm.joints[2].node = 0; }, "joints[2].node");
  rejects([](auto& arm) { arm.joints[2].node = 1; }, "joints[2].node: expected a node of its own");
  rejects([](auto& arm) { arm.joints[1].counts_per_turn = 8; }, "joints[1].counts_per_turn");
  rejects([](auto& arm) { arm.joints[1].zero_counts = 1U << 16; }, "joints[1].zero_counts");
  rejects([](auto& arm) { arm.joints[0].previous_from_joint(0, 0) = 2; }, "previous_from_joint");
  rejects([](auto& arm) { arm.joints[0].previous_from_joint(0, 3) = NAN; }, "previous_from_joint");
  rejects([](auto& arm) { arm.joints[0].zero_sigma_rad = -1; }, "zero_sigma_rad");
  rejects([](auto& arm) { arm.joints[0].link_sigma_mm = NAN; }, "link_sigma_mm");
  rejects([](auto& arm) { arm.last_from_body.setZero(); }, "last_from_body");
  rejects([](auto& arm) { arm.rest->angles_rad.pop_back(); }, "rest.angles");
  rejects([](auto& arm) { arm.rest->tolerance_rad = 0; }, "rest.tolerance");
}

}  // namespace
}  // namespace nav::devices
