// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <gtest/gtest.h>
#include <linux/can/error.h>

#include "devices/can/can_arm_emulator.hpp"
#include "devices/can/can_arm_source.hpp"
#include "session/arm_file.hpp"
#include "tests/devices/can_arm_models.hpp"
#include "tests/devices/source_bench.hpp"
#include "tests/kernel/commands.hpp"
#include "tests/support/matchers.hpp"

/// An arm and its emulated encoders on a virtual interface of a real kernel.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;

/// A machine that is emulated answers late: times are long, and none is tested. An answer that is
/// later than two periods cannot be told from one to a later SYNC, so the arm stands still.
const std::vector<double> kArmAngles{0.3, 0.5, -0.7, 0.2, 0.4, -0.1};

CanArmOptions patient_options() {
  CanArmOptions options{.arm = six_joint_arm()};
  options.period = milliseconds(20);
  options.reply = milliseconds(5000);
  options.lost = milliseconds(60000);
  options.first_retry = milliseconds(100);
  options.longest_retry = milliseconds(500);
  return options;
}

/// An arm at one interface, and its encoders at the same or another one of that bus.
class ArmKernelTest : public ::testing::Test {
 protected:
  void start(const std::string& interface, const std::string& interface_of_encoders) {
    start_emulator(interface_of_encoders);
    const CanArmOptions options = patient_options();
    auto made =
        CanArmSource::create(options, interface, CanArmSource::on_interface(interface, options.arm),
                             bench_.clock, bench_.diagnostics);
    EXPECT_TRUE(test::has_value(made));
    bench_.source = *std::move(made);
  }
  void start_emulator(const std::string& interface) {
    emulator_.reset();
    auto started = CanArmEmulator::start_on(interface, six_joint_arm(),
                                            [](std::uint64_t) { return kArmAngles; });
    ASSERT_TRUE(test::has_value(started));
    emulator_ = *std::move(started);
  }
  /// Takes samples until \p count of them have a pose. Each must be that of the arm.
  [[nodiscard]] ::testing::AssertionResult gives_true_poses(int count) {
    for (int valid = 0; valid < count;) {
      const auto got = bench_.sample();
      if (!got) return ::testing::AssertionFailure() << "no sample\n" << bench_.reports();
      const PoseSample& pose = std::get<PoseSample>(got->what);
      if (pose.pose.status != TrackingStatus::kOk) continue;  // An encoder answered late.
      ++valid;
      if (!is_true(pose)) return ::testing::AssertionFailure() << "a pose that is not the arm's";
    }
    return ::testing::AssertionSuccess();
  }
  [[nodiscard]] static bool is_true(const PoseSample& pose) {
    const ArmModel arm = six_joint_arm();
    std::vector<double> angles = kArmAngles;
    for (std::size_t i = 0; i < angles.size(); ++i) {
      angles[i] = joint_angle_rad(arm.joints[i], joint_counts(arm.joints[i], angles[i]));
    }
    return (arm_pose(arm, angles).base_from_body - pose.pose.tracker_from_body).norm() < 1e-9;
  }
  [[nodiscard]] bool until_lost(const char* cause) {
    return bench_.until(
        [&](const auto&) { return bench_.source->account().losses.contains(cause); });
  }

  std::unique_ptr<CanArmEmulator> emulator_;
  SourceBench<CanArmSource> bench_;
};

/// On a virtual interface.
class CanArmKernelTest : public ArmKernelTest {
 protected:
  CanArmKernelTest() { start(bus_.name(), bus_.name()); }
  ~CanArmKernelTest() override { emulator_.reset(); }
  kernel::VirtualBus bus_;
};

/// Between two controllers (sja1000, by the driver kvaser_pci) on the bus of the machine.
class CanControllerKernelTest : public ArmKernelTest {
 protected:
  CanControllerKernelTest() {
    for (const char* name : {"can0", "can1"}) set_up(name);
    start("can0", "can1");
  }
  ~CanControllerKernelTest() override {
    emulator_.reset();
    for (const char* name : {"can0", "can1"}) set_down(name);
  }
  static void set_up(const std::string& name) {
    EXPECT_EQ(kernel::shell("ip link set " + name + " up type can bitrate 500000 restart-ms 100"),
              0);
  }
  static void set_down(const std::string& name) {
    EXPECT_EQ(kernel::shell("ip link set " + name + " down"), 0);
  }
};

TEST_F(CanArmKernelTest, GivesTheTruth) {
  EXPECT_TRUE(gives_true_poses(20));
  EXPECT_EQ(bench_.source->account().connections, 1U) << bench_.reports();
}

TEST_F(CanArmKernelTest, AnEmergencyWithdrawsThePose) {
  ASSERT_TRUE(gives_true_poses(1));
  emulator_->emergency(2, {.code = 0x4200, .error_register = 1});
  ASSERT_TRUE(bench_.until([&](const auto&) {
    return bench_.reports().find("temperature is out of range") != std::string::npos;
  })) << bench_.reports();
  emulator_->emergency(2, {});
  EXPECT_TRUE(gives_true_poses(1));
}

TEST_F(CanArmKernelTest, AnInterfaceThatGoesDownAndUpIsTakenAgain) {
  ASSERT_TRUE(gives_true_poses(1));
  bus_.down();
  ASSERT_TRUE(until_lost("interface_down")) << bench_.reports();
  bus_.up();
  EXPECT_TRUE(gives_true_poses(5));
  EXPECT_EQ(bench_.source->account().connections, 2U) << bench_.reports();
}

TEST_F(CanArmKernelTest, AnInterfaceThatIsRemovedAndComesBackIsTakenAgain) {
  ASSERT_TRUE(gives_true_poses(1));
  bus_.remove();
  ASSERT_TRUE(until_lost("interface_gone")) << bench_.reports();
  bus_.add();
  start_emulator(bus_.name());
  EXPECT_TRUE(gives_true_poses(5));
}

TEST_F(CanArmKernelTest, BusOffLosesTheArmUntilTheBusServesAgain) {
  ASSERT_TRUE(gives_true_poses(1));
  emulator_->inject({.id = CAN_ERR_BUSOFF, .error = true, .size = CAN_ERR_DLC});
  ASSERT_TRUE(until_lost("bus_off")) << bench_.reports();
  EXPECT_TRUE(gives_true_poses(5));
}

TEST_F(CanArmKernelTest, FramesThatTheQueueLosesAreInTheAccount) {
  ASSERT_TRUE(gives_true_poses(1));
  const CanArmHealth before = bench_.source->account();
  for (int i = 0; i < 2000; ++i) {  // The source does not read meanwhile.
    emulator_->inject(can_heartbeat(six_joint_arm().joints[0].node, CanNodeState::kOperational));
  }
  ASSERT_TRUE(bench_.until([&](const auto&) {
    return bench_.source->account().bad.contains("kernel_drops");
  })) << bench_.reports();
  const CanArmHealth after = bench_.source->account();
  EXPECT_GE(after.frames - before.frames + after.bad.at("kernel_drops"), 2000U);
  EXPECT_TRUE(gives_true_poses(5));
}

TEST_F(CanControllerKernelTest, GivesTheTruth) {
  EXPECT_TRUE(gives_true_poses(20));
  EXPECT_EQ(bench_.source->account().connections, 1U) << bench_.reports();
}

TEST_F(CanControllerKernelTest, AnInterfaceThatGoesDownAndUpIsTakenAgain) {
  ASSERT_TRUE(gives_true_poses(1));
  set_down("can0");
  ASSERT_TRUE(until_lost("interface_down")) << bench_.reports();
  set_up("can0");
  EXPECT_TRUE(gives_true_poses(5));
}

/// The program itself; kernel_test.py reads its report and the log of the bus.
TEST_F(CanArmKernelTest, SondeReadsTheArmOfASessionFile) {
  const std::filesystem::path folder = kernel::results();
  std::ofstream(folder / "arm.json") << session::arm_file_text(six_joint_arm());
  std::ofstream(folder / "arm.toml")
      << "[source]\nkind = \"live\"\n[[devices]]\nid = \"arm\"\nkind = \"can-arm\"\n"
         "address = \"can:vcan0\"\narm = \"arm.json\"\nrate_hz = 50\nbodies = [ {name = \"Probe\"} "
         "]\n";
  bench_.source.reset();
  const std::string sonde = kernel::variable("SONDE");
  EXPECT_EQ(kernel::shell(sonde + " devices --session " + (folder / "arm.toml").string() +
                          " --seconds 15 --json " + (folder / "arm_report.json").string()),
            0);
  EXPECT_EQ(kernel::shell(sonde + " devices --json " + (folder / "inventory.json").string()), 0);
  EXPECT_GT(emulator_->syncs(), 0U);
}

}  // namespace
}  // namespace nav::devices
