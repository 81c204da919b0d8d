// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/can_arm_source.hpp"

#include <functional>
#include <gtest/gtest.h>
#include <linux/can/error.h>

#include "devices/can/can_arm_emulator.hpp"
#include "tests/devices/can_arm_models.hpp"
#include "tests/support/matchers.hpp"

/// The source against emulated encoders, over local sockets that carry the kernel's frames.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Duration kArmCertainly = seconds(20);  ///< Wait for what is certain to happen.

std::vector<double> angles_at(std::uint64_t sync) {
  const double t = 0.01 * static_cast<double>(sync);
  return {std::sin(t), 0.5 * std::cos(t), -0.7, 0.3 * std::sin(2 * t), 0.4, -t / 10};
}

struct ArmBench {
  void start(std::uint16_t profile = kEncoderProfile, ArmMotion motion = angles_at) {
    emulator = CanArmEmulator::start(truth, std::move(motion), profile);
    options.arm = believed;
    options.reply = milliseconds(100);
    options.heartbeat = milliseconds(50);
    options.lost = milliseconds(400);
    options.first_retry = milliseconds(20);
    options.longest_retry = milliseconds(50);
    auto made = CanArmSource::create(options, "emulated", emulator->opener(), clock, diagnostics);
    ASSERT_TRUE(test::has_value(made));
    source = *std::move(made);
  }
  [[nodiscard]] bool until(const std::function<bool(const PoseSample*)>& done) {
    const Timestamp end = clock.now() + kArmCertainly;
    while (clock.now() < end) {
      const auto sample = source->next(clock.now() + milliseconds(20));
      if (done(sample ? &std::get<PoseSample>(sample->what) : nullptr)) return true;
    }
    return false;
  }
  [[nodiscard]] bool until_account(const std::function<bool(const CanArmHealth&)>& done) {
    return until([&](const PoseSample*) { return done(source->account()); });
  }
  [[nodiscard]] bool until_valid() {
    return until([](const PoseSample* pose) {
      return pose != nullptr && pose->pose.status == TrackingStatus::kOk;
    });
  }
  [[nodiscard]] std::string reports() const {
    std::string all;
    for (const auto& entry : diagnostics.entries()) all += entry.message + "\n";
    return all;
  }
  /// True if the pose is one that the arm has been in, to the resolution of its encoders.
  [[nodiscard]] bool is_of_one_instant(const PoseSample& pose) const {
    for (std::uint64_t sync = 0; sync < emulator->syncs(); ++sync) {
      std::vector<double> angles = angles_at(sync);
      for (std::size_t i = 0; i < angles.size(); ++i) {
        angles[i] = joint_angle_rad(truth.joints[i], joint_counts(truth.joints[i], angles[i]));
      }
      const ArmPose there = arm_pose(truth, angles);
      if ((there.base_from_body - pose.pose.tracker_from_body).norm() < 1e-9) return true;
    }
    return false;
  }

  MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  ArmModel truth = six_joint_arm(), believed = six_joint_arm();
  CanArmOptions options;
  std::unique_ptr<CanArmEmulator> emulator;
  std::unique_ptr<CanArmSource> source;
};

class CanArmSourceTest : public ::testing::Test {
 protected:
  ArmBench bench_;
};

TEST_F(CanArmSourceTest, GivesPosesOfOneInstant) {
  bench_.start();
  std::uint64_t next = 0;
  Timestamp before{};
  for (int i = 0; i < 100; ++i) {
    const auto sample = bench_.source->next(bench_.clock.now() + kArmCertainly);
    ASSERT_TRUE(test::has_value(sample)) << bench_.reports();
    const PoseSample& pose = std::get<PoseSample>(sample->what);
    EXPECT_EQ(sample->sequence, next++);
    EXPECT_GE(sample->received, before);
    EXPECT_LE(pose.pose.acquired, pose.pose.received);
    before = sample->received;
    if (pose.pose.status != TrackingStatus::kOk) continue;  // A loaded machine may miss one.
    EXPECT_TRUE(bench_.is_of_one_instant(pose));
    EXPECT_GT(*pose.tracker_error_mm, 0);
  }
  EXPECT_EQ(bench_.source->health().state, SourceState::kStreaming);
  EXPECT_EQ(bench_.source->account().connections, 1U) << bench_.reports();
}

TEST_F(CanArmSourceTest, AMissingJointWithdrawsThePose) {
  bench_.start();
  ASSERT_TRUE(bench_.until_valid()) << bench_.reports();
  bench_.emulator->miss(3, 2);
  int invalid = 0;
  ASSERT_TRUE(bench_.until([&](const PoseSample* pose) {
    if (pose == nullptr || pose->pose.status == TrackingStatus::kOk) return invalid >= 2;
    EXPECT_EQ(pose->pose.status, TrackingStatus::kInvalid);
    EXPECT_FALSE(pose->pose.tracker_from_body.allFinite());
    ++invalid;
    return false;
  }));
  EXPECT_GE(bench_.source->account().bad.at("missing_joint"), 2U);
  EXPECT_NE(bench_.reports().find("joint 4 (node 4) misses SYNC"), std::string::npos);
  EXPECT_TRUE(bench_.until_valid()) << bench_.reports();
}

TEST_F(CanArmSourceTest, ALateAnswerIsNotTakenForTheNextOne) {
  bench_.options.period = milliseconds(20);
  bench_.start();
  ASSERT_TRUE(bench_.until_valid());
  bench_.emulator->delay(2, 5, milliseconds(30));  // In the pause after the SYNC.
  ASSERT_TRUE(bench_.until([&](const PoseSample* pose) {
    if (pose != nullptr && pose->pose.status == TrackingStatus::kOk) {
      EXPECT_TRUE(bench_.is_of_one_instant(*pose));
    }
    const auto bad = bench_.source->account().bad;
    const auto late = bad.find("late");
    return late != bad.end() && late->second >= 5;
  })) << bench_.reports();
  EXPECT_TRUE(bench_.until_valid());
}

TEST_F(CanArmSourceTest, ASilentEncoderLosesTheArm) {
  bench_.start();
  ASSERT_TRUE(bench_.until_valid());
  bench_.emulator->silence(4);
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.losses.contains("node_silent"); }));
  EXPECT_NE(bench_.reports().find("joint 5 (node 5) gives no sign for 400 ms"), std::string::npos)
      << bench_.reports();
  EXPECT_EQ(bench_.source->health().state, SourceState::kWaiting);
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.losses.contains("no_reply"); }));
  bench_.emulator->revive();
  EXPECT_TRUE(bench_.until_valid()) << bench_.reports();
  EXPECT_EQ(bench_.source->account().connections, 2U);
}

TEST_F(CanArmSourceTest, AnEncoderThatRestartsIsSetUpAgain) {
  bench_.start();
  ASSERT_TRUE(bench_.until_valid());
  bench_.emulator->reboot(1);
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.connections == 2; }))
      << bench_.reports();
  EXPECT_EQ(bench_.source->account().bad.at("reboot"), 1U);
  EXPECT_TRUE(bench_.until_valid());
}

TEST_F(CanArmSourceTest, AnErrorOfAnEncoderWithdrawsThePoseUntilItIsGone) {
  bench_.start();
  ASSERT_TRUE(bench_.until_valid());
  bench_.emulator->emergency(0, {0x5003, 1});
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.bad.contains("emergency"); }));
  const std::uint64_t poses = bench_.source->account().poses;
  int invalid = 0;
  ASSERT_TRUE(bench_.until([&](const PoseSample* pose) {
    invalid += pose != nullptr && pose->pose.status == TrackingStatus::kInvalid;
    return invalid == 10;
  }));
  EXPECT_EQ(bench_.source->account().poses, poses);
  bench_.emulator->emergency(0, {0, 0});
  EXPECT_TRUE(bench_.until_valid());
}

TEST_F(CanArmSourceTest, NoPoseBeforeTheArmWasShownAtRest) {
  bench_.believed.rest = ArmRest{std::vector<double>(6, 0.0), 0.1};
  bench_.believed.joints[1].zero_counts += 16384;  // A quarter turn off.
  bench_.start(kEncoderProfile, [](std::uint64_t) { return std::vector<double>(6, 0.0); });
  int invalid = 0;
  ASSERT_TRUE(bench_.until([&](const PoseSample* pose) {
    EXPECT_TRUE(pose == nullptr || pose->pose.status == TrackingStatus::kInvalid);
    return (invalid += pose != nullptr) == 20;
  }));
  EXPECT_NE(bench_.reports().find("joint 2 (node 2) is at 90 degrees, expected 0"),
            std::string::npos)
      << bench_.reports();
  EXPECT_EQ(bench_.source->health().cause, "rest_not_shown");
  ArmBench right;
  right.believed.rest = ArmRest{std::vector<double>(6, 0.0), 0.1};
  right.start(kEncoderProfile, [](std::uint64_t sync) {
    return sync < 5 ? std::vector<double>(6, 0.0) : angles_at(sync);
  });
  EXPECT_TRUE(right.until_valid()) << right.reports();
  EXPECT_TRUE(right.until([&](const PoseSample* pose) {
    return pose != nullptr && pose->pose.status == TrackingStatus::kOk &&
           right.emulator->syncs() > 20;
  })) << "away from its rest";
}

TEST_F(CanArmSourceTest, AWrongEncoderIsNamed) {
  bench_.start(401);
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.losses.contains("setup"); }));
  EXPECT_NE(bench_.reports().find("expected an encoder (CiA 406), found a device of profile 401"),
            std::string::npos);
  ArmBench other;
  other.believed.joints[5].counts_per_turn = 1U << 17;
  other.start();
  ASSERT_TRUE(other.until_account([](const auto& h) { return h.losses.contains("setup"); }));
  EXPECT_NE(other.reports().find("joint 6 (node 7): expected 131072 counts per turn, found 65536"),
            std::string::npos)
      << other.reports();
}

TEST_F(CanArmSourceTest, ReportsOfTheControllerAreCountedAndBusOffIsALoss) {
  bench_.start();
  ASSERT_TRUE(bench_.until_valid());
  CanFrame passive{.id = CAN_ERR_CRTL, .error = true, .size = 8};
  passive.data[1] = CAN_ERR_CRTL_RX_PASSIVE;
  bench_.emulator->inject(passive);
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.bad.contains("error_passive"); }));
  EXPECT_TRUE(bench_.source->account().losses.empty());
  bench_.emulator->inject({.id = CAN_ERR_BUSOFF, .error = true, .size = 8});
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.losses.contains("bus_off"); }));
  EXPECT_TRUE(bench_.until_valid()) << "the controller came back";
}

TEST_F(CanArmSourceTest, ForeignAndBrokenFramesCostNothing) {
  bench_.start();
  ASSERT_TRUE(bench_.until_valid());
  bench_.emulator->inject({.id = 0x1ABCDEF, .extended = true, .size = 8});
  bench_.emulator->inject({.id = 0x281, .remote = true});
  bench_.emulator->inject({.id = 0x27F, .size = 8});
  bench_.emulator->inject({.id = 0x281, .size = 2});  // Too short for a position.
  bench_.emulator->inject_bytes(std::vector<std::byte>(7));
  auto nine = encode_can({.id = 0x281, .size = 8});
  nine[4] = std::byte{9};
  bench_.emulator->inject_bytes({nine.begin(), nine.end()});
  ASSERT_TRUE(bench_.until_account([](const auto& h) {
    const auto found = h.bad.find("malformed");
    return found != h.bad.end() && found->second >= 3;
  }));
  EXPECT_EQ(bench_.source->account().connections, 1U);
  EXPECT_TRUE(bench_.until_valid());
}

TEST_F(CanArmSourceTest, ABusThatIsUnpluggedComesBack) {
  bench_.start();
  ASSERT_TRUE(bench_.until_valid());
  bench_.emulator->unplug();
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.losses.contains("closed"); }));
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.losses.contains("unavailable"); }));
  bench_.emulator->replug();
  EXPECT_TRUE(bench_.until_valid()) << bench_.reports();
  EXPECT_EQ(bench_.source->health().reconnects, 1U);
}

TEST_F(CanArmSourceTest, AnInterfaceThatIsNotThereIsNamed) {
  const auto opened = open_can("nocan7", {});
  ASSERT_FALSE(opened.has_value());
  EXPECT_NE(opened.error().message.find("nocan7: expected a CAN interface"), std::string::npos);
}

TEST_F(CanArmSourceTest, RejectsTimesOutOfRange) {
  const auto rejects = [&](const std::function<void(CanArmOptions&)>& change) {
    CanArmOptions options;
    options.arm = six_joint_arm();
    change(options);
    return !validate(options).has_value();
  };
  EXPECT_FALSE(rejects([](auto&) {}));
  EXPECT_TRUE(rejects([](auto& o) { o.body.clear(); }));
  EXPECT_TRUE(rejects([](auto& o) { o.period = Duration(0); }));
  EXPECT_TRUE(rejects([](auto& o) { o.lost = o.heartbeat; }));
  EXPECT_TRUE(rejects([](auto& o) { o.reply = Duration(-1); }));
  EXPECT_TRUE(rejects([](auto& o) { o.longest_retry = milliseconds(1); }));
  EXPECT_TRUE(rejects([](auto& o) { o.arm.joints.clear(); }));
}

}  // namespace
}  // namespace nav::devices
