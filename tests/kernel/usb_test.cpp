// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <thread>

#include "devices/usb/libusb_link.hpp"
#include "tests/devices/source_bench.hpp"
#include "tests/devices/usb_rigs.hpp"
#include "tests/kernel/commands.hpp"
#include "tests/support/matchers.hpp"

/// Emulated devices that the kernel of the machine has as USB devices (vhci_hcd), read by libusb.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr double kUsbFloatMm = 1e-3;  ///< Rounding of a float in centimetres, up to 10 m.

/// A machine that is emulated answers late: times are long, and none is tested.
UsbTimes patient_usb_times() {
  return {.silence = seconds(4),
          .lost = seconds(8),
          .first_retry = milliseconds(100),
          .longest_retry = milliseconds(500)};
}

/// Gives the exported device to the kernel, as a user does.
[[nodiscard]] bool plug_in(const UsbipServer& server) {
  return kernel::shell("usbip --tcp-port " + std::to_string(server.port()) +
                       " attach --remote=127.0.0.1 --busid=1-1") == 0;
}

template <class SourceKind>
struct UsbBench : SourceBench<SourceKind> {
  std::uint64_t bad(const std::string& cause) const {
    const auto health = this->source->health();
    const auto found = health.bad_messages.find(cause);
    return found == health.bad_messages.end() ? 0 : found->second;
  }
  /// Takes samples until \p count of them are good; false if a good one is not true, or none comes.
  template <class IsGood, class IsTrue>
  [[nodiscard]] bool gives(int count, IsGood is_good, IsTrue is_true) {
    for (int good = 0; good < count;) {
      const auto got = this->sample();
      if (!got) return false;
      if (!is_good(*got)) continue;
      ++good;
      if (!is_true(*got)) return false;
    }
    return true;
  }
};

class PolhemusKernelTest : public ::testing::Test {
 protected:
  PolhemusKernelTest() : emulator_(emulated_liberty(2)) {
    PolhemusOptions options{
        .bodies = {{.name = "Probe", .station = 1}, {.name = "Reference", .station = 2}}};
    options.times = patient_usb_times();
    bench_.source = *PolhemusSource::create(
        options, "usb:0f44:ff20", [] { return open_usb(kLibertyId); }, bench_.clock,
        bench_.diagnostics);
  }
  ~PolhemusKernelTest() override {
    bench_.source.reset();
    emulator_->server().unplug();
  }
  [[nodiscard]] static bool is_good(const Sample& got) {
    const auto* pose = std::get_if<PoseSample>(&got.what);
    return pose != nullptr && pose->pose.status == TrackingStatus::kOk;
  }
  [[nodiscard]] static bool is_true(const Sample& got) {
    const Eigen::Matrix4d& matrix = std::get<PoseSample>(got.what).pose.tracker_from_body;
    const double frame = std::round(matrix(0, 3) / kPolhemusStepMm);
    const auto truth =
        polhemus_truth(static_cast<int>(got.stream) + 1, static_cast<std::uint32_t>(frame));
    return (matrix.topRightCorner<3, 1>() - Eigen::Vector3d(truth.position_mm.data())).norm() <
           kUsbFloatMm;
  }
  [[nodiscard]] bool gives_true_poses(int count) { return bench_.gives(count, is_good, is_true); }

  std::unique_ptr<PolhemusEmulator> emulator_;
  UsbBench<PolhemusSource> bench_;
};

TEST_F(PolhemusKernelTest, GivesTheTruth) {
  ASSERT_TRUE(plug_in(emulator_->server()));
  EXPECT_TRUE(gives_true_poses(200)) << bench_.reports();
  EXPECT_EQ(bench_.source->health().state, SourceState::kStreaming);
  EXPECT_EQ(bench_.source->health().reconnects, 0U) << bench_.reports();
  EXPECT_EQ(emulator_->tracker().commands().back(), "c");
}

TEST_F(PolhemusKernelTest, EachFaultIsCountedByItsCause) {
  struct Case {
    PolhemusFault fault;
    const char* cause;
  };
  ASSERT_TRUE(plug_in(emulator_->server()));
  ASSERT_TRUE(gives_true_poses(1)) << bench_.reports();
  for (const Case& one : {Case{PolhemusFault::kStall, "stall"},
                          {PolhemusFault::kOverflow, "overflow"},
                          {PolhemusFault::kProtocol, "transfer_error"},
                          {PolhemusFault::kEmpty, "empty"},
                          {PolhemusFault::kCut, "cut"},
                          {PolhemusFault::kLost, "lost_frames"}}) {
    const auto before = bench_.bad(one.cause);
    emulator_->tracker().inject(one.fault, 1);
    ASSERT_TRUE(bench_.until([&](const auto&) { return bench_.bad(one.cause) > before; }))
        << one.cause << "\n"
        << bench_.reports();
    EXPECT_TRUE(gives_true_poses(5)) << one.cause << "\n" << bench_.reports();
  }
  EXPECT_GE(emulator_->server().cleared_halts(), 1U)
      << "the kernel asked for no halt to be cleared";
  EXPECT_EQ(bench_.source->health().reconnects, 0U) << bench_.reports();
}

TEST_F(PolhemusKernelTest, ASilentDeviceIsLostAndTakenAgain) {
  ASSERT_TRUE(plug_in(emulator_->server()));
  ASSERT_TRUE(gives_true_poses(1)) << bench_.reports();
  emulator_->tracker().hush(true);
  ASSERT_TRUE(bench_.until([](const auto& h) { return h.cause == "silent"; })) << bench_.reports();
  emulator_->tracker().hush(false);
  EXPECT_TRUE(gives_true_poses(5)) << bench_.reports();
  EXPECT_EQ(bench_.source->health().reconnects, 1U) << bench_.reports();
}

TEST_F(PolhemusKernelTest, ADeviceThatIsUnpluggedInMidStreamComesBack) {
  ASSERT_TRUE(plug_in(emulator_->server()));
  for (std::uint64_t times = 1; times <= 3; ++times) {
    ASSERT_TRUE(gives_true_poses(20)) << bench_.reports();
    emulator_->server().unplug();
    ASSERT_TRUE(bench_.until([](const auto& h) { return h.state == SourceState::kWaiting; }))
        << bench_.reports();
    EXPECT_THAT(bench_.source->health().cause, ::testing::AnyOf("unplugged", "unavailable"));
    emulator_->server().replug();
    ASSERT_TRUE(plug_in(emulator_->server()));
    ASSERT_TRUE(gives_true_poses(5)) << bench_.reports();
    EXPECT_EQ(bench_.source->health().reconnects, times) << bench_.reports();
  }
  EXPECT_NE(bench_.reports().find("unplugged"), std::string::npos) << bench_.reports();
}

TEST_F(PolhemusKernelTest, ADeviceThatAnotherProgramHasIsNamed) {
  ASSERT_TRUE(plug_in(emulator_->server()));
  ASSERT_TRUE(gives_true_poses(1)) << bench_.reports();
  EXPECT_TRUE(test::rejects(open_usb(kLibertyId), ErrorCode::kUnavailable,
                            {"usb:0f44:ff20", "another program has claimed it"}));
  EXPECT_TRUE(test::rejects(open_usb({kPolhemusVendor, kLibertyProduct, "no such"}),
                            ErrorCode::kNotFound, {"expected this serial number"}));
  EXPECT_TRUE(gives_true_poses(5)) << bench_.reports();
}

/// The program itself records both devices, whose faults come by chance; kernel_test.py reads its
/// report.
TEST(UsbSondeKernelTest, SondeRecordsATrackerAndAProbeOnUsb) {
  const auto liberty = PolhemusEmulator::start(
      {.stations = 2, .see = polhemus_truth},
      {.rate = 0.02, .kinds = {PolhemusFault::kStall, PolhemusFault::kLost, PolhemusFault::kCut}});
  const auto see_more = IntersonEmulator::start(
      {.see = see_more_truth},
      {.rate = 0.05, .kinds = {IntersonFault::kStall, IntersonFault::kLostLine}});
  ASSERT_TRUE(test::has_value(liberty));
  ASSERT_TRUE(test::has_value(see_more));
  ASSERT_TRUE(plug_in((*liberty)->server()));
  ASSERT_TRUE(plug_in((*see_more)->server()));
  const std::string sonde = kernel::variable("SONDE");
  const std::string folder = kernel::results().string();
  EXPECT_EQ(kernel::shell(sonde + " devices --json " + folder + "/usb_inventory.json"), 0);
  EXPECT_EQ(kernel::shell(sonde + " record --session tests/kernel/usb_recorded.toml --out " +
                          folder + "/usb.mcap --seconds 15 --json " + folder + "/usb_report.json"),
            0);
  EXPECT_EQ(kernel::shell(sonde + " info " + folder + "/usb.mcap"), 0);
  (*liberty)->server().unplug();
  (*see_more)->server().unplug();
}

class IntersonKernelTest : public ::testing::Test {
 protected:
  IntersonKernelTest() : emulator_(emulated_see_more()) {
    IntersonOptions options = see_more_options();
    options.settings.images_hz = 10;
    options.times = patient_usb_times();
    scan_ = std::make_unique<SectorScan>(options.shape, kIntersonLines, kIntersonSamples);
    bench_.source = *IntersonSource::create(
        options, "usb:1921:0090", [] { return open_usb(kSeeMoreId); }, bench_.clock,
        bench_.diagnostics);
  }
  ~IntersonKernelTest() override {
    bench_.source.reset();
    emulator_->server().unplug();
  }
  [[nodiscard]] bool gives_true_images(int count) {
    const auto is_good = [](const Sample& got) {
      return std::holds_alternative<UltrasoundImage>(got.what);
    };
    const auto is_true = [&](const Sample& got) {
      const auto& pixels = std::get<UltrasoundImage>(got.what).pixels;
      const int bright = pixels.at(pixels.width() / 2, pixels.height() / 2);
      const auto truth = scan_->convert(see_more_truth(static_cast<std::uint64_t>(bright / 2)));
      return std::ranges::equal(pixels.pixels(), truth.pixels());
    };
    return bench_.gives(count, is_good, is_true);
  }

  std::unique_ptr<IntersonEmulator> emulator_;
  std::unique_ptr<SectorScan> scan_;
  UsbBench<IntersonSource> bench_;
};

TEST_F(IntersonKernelTest, GivesTheTruthAndSwitchesItsVoltageOff) {
  ASSERT_TRUE(plug_in(emulator_->server()));
  EXPECT_TRUE(gives_true_images(10)) << bench_.reports();
  EXPECT_EQ(emulator_->probe().reg(interson::kVoltage), 100);
  bench_.source->stop();
  EXPECT_EQ(bench_.source->next(bench_.clock.now()).error().code, ErrorCode::kCancelled);
  EXPECT_EQ(emulator_->probe().reg(interson::kVoltageOn), 0);
  EXPECT_EQ(emulator_->probe().reg(interson::kMotor), 0);
}

TEST_F(IntersonKernelTest, EachFaultIsCountedByItsCause) {
  struct Case {
    IntersonFault fault;
    const char* cause;
  };
  ASSERT_TRUE(plug_in(emulator_->server()));
  ASSERT_TRUE(gives_true_images(1)) << bench_.reports();
  for (const Case& one : {Case{IntersonFault::kStall, "stall"},
                          {IntersonFault::kOverflow, "overflow"},
                          {IntersonFault::kProtocol, "transfer_error"},
                          {IntersonFault::kLostLine, "incomplete"},
                          {IntersonFault::kCutLine, "cut_line"}}) {
    const auto before = bench_.bad(one.cause);
    emulator_->probe().inject(one.fault, 1);
    ASSERT_TRUE(bench_.until([&](const auto&) { return bench_.bad(one.cause) > before; }))
        << one.cause << "\n"
        << bench_.reports();
    EXPECT_TRUE(gives_true_images(2)) << one.cause << "\n" << bench_.reports();
  }
  EXPECT_EQ(bench_.source->health().reconnects, 0U) << bench_.reports();
}

TEST_F(IntersonKernelTest, AProbeThatIsUnpluggedInMidStreamComesBack) {
  ASSERT_TRUE(plug_in(emulator_->server()));
  ASSERT_TRUE(gives_true_images(2)) << bench_.reports();
  emulator_->server().unplug();
  ASSERT_TRUE(bench_.until([](const auto& h) { return h.state == SourceState::kWaiting; }))
      << bench_.reports();
  emulator_->server().replug();
  ASSERT_TRUE(plug_in(emulator_->server()));
  EXPECT_TRUE(gives_true_images(2)) << bench_.reports();
  EXPECT_EQ(bench_.source->health().reconnects, 1U) << bench_.reports();
}

}  // namespace
}  // namespace nav::devices
