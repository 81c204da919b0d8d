// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/can_arm_sender.hpp"

#include <gtest/gtest.h>

#include "devices/can/emulated_arm.hpp"
#include "tests/devices/source_bench.hpp"
#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

/// One step of the encoders, 24 µrad, at a lever of less than a metre, for six joints.
constexpr double kStepsMm = 0.15;

const StreamInfo kProbe{"Probe", StreamKind::kPoses, ToolRole::kProbe};

Sample pose_at(double x_mm) {
  PoseSample pose;
  pose.pose.status = TrackingStatus::kOk;
  pose.pose.tracker_from_body = Eigen::Matrix4d::Identity();
  pose.pose.tracker_from_body.topRightCorner<3, 1>() = Eigen::Vector3d(x_mm, 40, -900);
  Sample sample;
  sample.what = pose;
  return sample;
}

/// A sender whose encoders are at one end of local sockets, and a source at the other.
class CanArmSenderTest : public ::testing::Test {
 protected:
  /// Places the arm by a first pose, and begins to read it.
  void start(CanArmFaultPlan plan) {
    sender_ = std::make_unique<CanArmSender>(
        "Probe", std::move(plan), [this](const ArmModel& arm, ArmMotion motion) {
          auto emulator = CanArmEmulator::start(arm, std::move(motion));
          open_ = emulator->opener();
          return Result<std::unique_ptr<CanArmEmulator>>(std::move(emulator));
        });
    const auto placed = sender_->send(kProbe, pose_at(0));
    ASSERT_TRUE(test::has_value(placed));
    ASSERT_TRUE(*placed);
    CanArmOptions options{.arm = **placed};
    options.period = std::chrono::milliseconds(10);
    options.lost = std::chrono::seconds(20);
    auto made = CanArmSource::create(options, "test", open_, bench_.clock, bench_.diagnostics);
    ASSERT_TRUE(test::has_value(made));
    bench_.source = *std::move(made);
  }
  /// The next sample whose pose is valid, or is not.
  [[nodiscard]] std::optional<PoseSample> next(bool valid) {
    for (int i = 0; i < 2000; ++i) {
      const auto got = bench_.sample();
      if (!got) return std::nullopt;
      const PoseSample pose = std::get<PoseSample>(got->what);
      if ((pose.pose.status == TrackingStatus::kOk) == valid) return pose;
    }
    return std::nullopt;
  }

  CanOpener open_;
  std::unique_ptr<CanArmSender> sender_;
  SourceBench<CanArmSource> bench_;
};

TEST_F(CanArmSenderTest, TheArmShowsThePosesOfTheBody) {
  start({});
  for (const double x_mm : {0.0, 5.0, -20.0, 60.0}) {
    const auto sent = sender_->send(kProbe, pose_at(x_mm));
    ASSERT_TRUE(test::has_value(sent));
    EXPECT_FALSE(*sent) << "the arm is placed once";
    // Poses that were asked for before may still come.
    double off_mm = 1000;
    for (int i = 0; i < 50 && off_mm > kStepsMm; ++i) {
      const auto pose = next(true);
      ASSERT_TRUE(pose) << bench_.reports();
      off_mm =
          (pose->pose.tracker_from_body.topRightCorner<3, 1>() - Eigen::Vector3d(x_mm, 40, -900))
              .norm();
    }
    EXPECT_LT(off_mm, kStepsMm) << x_mm;
  }
  EXPECT_GE(sender_->syncs(), 4U);
  EXPECT_EQ(sender_->out_of_reach(), 0U);
}

TEST_F(CanArmSenderTest, WhatIsNotSeenOrReachedIsNotShownAgain) {
  start({});
  ASSERT_TRUE(next(true)) << bench_.reports();
  Sample hidden = pose_at(0);
  std::get<PoseSample>(hidden.what).pose.status = TrackingStatus::kOccluded;
  ASSERT_TRUE(test::has_value(sender_->send(kProbe, hidden)));
  ASSERT_TRUE(next(false)) << bench_.reports();
  ASSERT_TRUE(test::has_value(sender_->send(kProbe, pose_at(0))));
  ASSERT_TRUE(next(true)) << bench_.reports();
  ASSERT_TRUE(test::has_value(sender_->send(kProbe, pose_at(5000))));
  ASSERT_TRUE(next(false)) << bench_.reports();
  EXPECT_EQ(sender_->out_of_reach(), 1U);
  EXPECT_GT(bench_.source->account().bad.at("missing_joint"), 0U);
}

TEST_F(CanArmSenderTest, FaultsAreCountedByTheReader) {
  start({.seed = 3,
         .rate = 0.3,
         .kinds = {CanArmFault::kMissing, CanArmFault::kEmergency, CanArmFault::kForeign}});
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(test::has_value(sender_->send(kProbe, pose_at(0.1 * i))));
    ASSERT_TRUE(bench_.sample()) << bench_.reports();
  }
  const CanArmHealth health = bench_.source->account();
  EXPECT_GT(health.bad.at("missing_joint"), 0U);
  EXPECT_GT(health.bad.at("emergency"), 0U);
  ASSERT_TRUE(test::has_value(sender_->send(kProbe, pose_at(0))));
  EXPECT_TRUE(next(true)) << bench_.reports();
}

TEST(CanArmSenderStartTest, AnInterfaceThatIsNotThereIsNamed) {
  const auto sender = CanArmSender::on_interface("nocan7", "Probe", {});
  ASSERT_FALSE(sender);
  EXPECT_NE(sender.error().message.find("nocan7"), std::string::npos) << sender.error().message;
}

TEST_F(CanArmSenderTest, OtherStreamsAreLeftOut) {
  start({});
  const StreamInfo needle{"Needle", StreamKind::kPoses, ToolRole::kNeedle};
  ASSERT_TRUE(test::has_value(sender_->send(needle, pose_at(5000))));
  EXPECT_EQ(sender_->out_of_reach(), 0U);
}

}  // namespace
}  // namespace nav::devices
