// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/input-event-codes.h>
#include <unistd.h>

#include "devices/buttons/foot_switch_source.hpp"
#include "tests/devices/source_bench.hpp"
#include "tests/kernel/commands.hpp"
#include "tests/support/matchers.hpp"

/// A foot switch that the kernel has by USB and HID: its other side is the kernel's own gadget.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;

constexpr HidId kPedalId{0x05F3, 0x00FF};

[[nodiscard]] bool pedal(const std::string& command) {
  return kernel::shell("tests/kernel/foot_switch.sh " + command) == 0;
}

class FootSwitchKernelTest : public ::testing::Test {
 protected:
  FootSwitchKernelTest() {
    EXPECT_TRUE(pedal("add 05f3 00ff"));
    FootSwitchOptions options;
    options.buttons = {{"left", BTN_0, ButtonAction::kMark}, {"right", BTN_2}};
    options.times = {.first_retry = milliseconds(50), .longest_retry = milliseconds(500)};
    bench_.source = *FootSwitchSource::create(options, "hid:05f3:00ff",
                                              FootSwitchSource::with_id(kPedalId, options.buttons),
                                              bench_.clock, bench_.diagnostics);
    EXPECT_TRUE(is_ready()) << bench_.reports();
  }
  ~FootSwitchKernelTest() override {
    bench_.source.reset();
    EXPECT_TRUE(pedal("remove"));
  }
  [[nodiscard]] bool is_ready() {
    return bench_.until([](const auto& h) { return h.state == SourceState::kReady; });
  }
  /// Sends a report with these pedals down: bit 0 is the left one.
  static void press(std::uint8_t pedals) {
    const FileDescriptor device(::open("/dev/hidg0", O_WRONLY | O_CLOEXEC));
    EXPECT_EQ(::write(device.get(), &pedals, 1), 1);
  }
  /// The next sample is of this stream, and pressed or not.
  void expect_button(std::size_t stream, bool pressed) {
    const auto got = bench_.sample();
    ASSERT_TRUE(got) << bench_.reports();
    EXPECT_EQ(got->stream, stream);
    EXPECT_EQ(std::get<ButtonSample>(got->what).pressed, pressed);
    EXPECT_LE(std::get<ButtonSample>(got->what).acquired, got->received);
  }
  SourceBench<FootSwitchSource> bench_;
};

TEST_F(FootSwitchKernelTest, PressAndReleaseOfEachPedalComeOnceAndInOrder) {
  press(0b001);
  expect_button(0, true);
  press(0b101);
  expect_button(1, true);
  press(0b100);
  expect_button(0, false);
  press(0b000);
  expect_button(1, false);
}

TEST_F(FootSwitchKernelTest, TheDeviceIsGrabbed) {
  const auto path = find_input(kPedalId, {BTN_0});
  ASSERT_TRUE(test::has_value(path));
  EXPECT_TRUE(test::rejects(open_input(*path), ErrorCode::kUnavailable, {"another program"}));
  const FileDescriptor listener(::open(path->c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  ASSERT_TRUE(listener.is_open());
  press(0b001);
  expect_button(0, true);
  std::array<char, 64> bytes{};
  EXPECT_EQ(::read(listener.get(), bytes.data(), bytes.size()), -1)
      << "another program hears the pedal";
}

TEST_F(FootSwitchKernelTest, KeysThatAreDownAreKnownToTheKernel) {
  press(0b100);
  expect_button(1, true);
  const auto path = find_input(kPedalId, {BTN_0});
  ASSERT_TRUE(test::has_value(path));
  const FileDescriptor other(::open(path->c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  const auto down = keys_down(other);
  ASSERT_TRUE(down);
  const auto is_down = [&](int key) {
    return ((*down)[static_cast<std::size_t>(key / 8)] >> (key % 8) & 1) != 0;
  };
  EXPECT_TRUE(is_down(BTN_2));
  EXPECT_FALSE(is_down(BTN_0));
}

TEST_F(FootSwitchKernelTest, ASwitchThatIsUnpluggedComesBack) {
  press(0b001);
  expect_button(0, true);
  ASSERT_TRUE(pedal("unplug"));
  ASSERT_TRUE(bench_.until([](const auto& h) { return h.state == SourceState::kWaiting; }))
      << bench_.reports();
  ASSERT_TRUE(pedal("plug"));
  ASSERT_TRUE(is_ready()) << bench_.reports();
  EXPECT_EQ(bench_.source->health().reconnects, 1U);
  press(0b100);
  expect_button(1, true);
}

}  // namespace
}  // namespace nav::devices
