// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <linux/can/error.h>

#include "tests/devices/button_rigs.hpp"
#include "tests/devices/source_bench.hpp"
#include "tests/support/matchers.hpp"

/// Devices of buttons over local sockets that carry the bytes of the kernel.
namespace nav::devices {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

ButtonTimes quick_times() {
  return {.streaming = milliseconds(50),
          .first_retry = milliseconds(10),
          .longest_retry = milliseconds(20)};
}

template <class SourceKind>
struct ButtonBench : SourceBench<SourceKind> {
  explicit ButtonBench(int type) : line(type) {}

  /// Runs the device for a while; true if nothing came.
  bool is_quiet(Duration time) {
    const Timestamp end = this->clock.now() + time;
    while (this->clock.now() < end) {
      if (this->source->next(end)) return false;
    }
    return true;
  }
  ButtonLine line;
};

struct FootBench : ButtonBench<FootSwitchSource> {
  FootBench() : ButtonBench(SOCK_STREAM) {
    FootSwitchOptions options;
    options.buttons = {{"left", BTN_0, ButtonAction::kMark}, {"right", BTN_1}};
    options.times = quick_times();
    options.down = [this](const FileDescriptor&) { return down; };
    source = *FootSwitchSource::create(options, "hid:05f3:00ff", line.opener(), clock, diagnostics);
    EXPECT_TRUE(until([](const auto& h) { return h.state == SourceState::kReady; }));
  }
  std::optional<std::vector<std::uint8_t>> down;
};

struct CanBench : ButtonBench<CanButtonSource> {
  explicit CanBench(Duration silence = Duration(0)) : ButtonBench(SOCK_SEQPACKET) {
    CanButtonOptions options;
    options.buttons = {{.name = "left", .frame = 0x18A, .action = ButtonAction::kFreeze},
                       {.name = "right", .frame = 0x18A, .byte = 1, .bit = 7}};
    options.times = quick_times();
    options.times.silence = silence;
    source = *CanButtonSource::create(options, "can0", line.opener(), clock, diagnostics);
    EXPECT_TRUE(until([](const auto& h) { return h.state == SourceState::kReady; }));
  }
  void send(std::uint8_t first, std::uint8_t second = 0) {
    line.frame({.id = 0x18A, .size = 2, .data = {first, second}});
  }
};

const ButtonSample& button_of(const Sample& sample) { return std::get<ButtonSample>(sample.what); }

TEST(FootSwitchSourceTest, PressAndReleaseCarryTheKernelsTime) {
  FootBench bench;
  ASSERT_EQ(bench.source->streams().size(), 2U);
  EXPECT_EQ(bench.source->streams()[0].kind, StreamKind::kButtons);
  EXPECT_EQ(bench.source->streams()[0].action, ButtonAction::kMark);
  const Timestamp before = bench.clock.now();
  const microseconds then = kernel_now();
  std::this_thread::sleep_for(milliseconds(40));
  bench.line.key(BTN_0, 1, then);
  bench.line.key(BTN_0, 2, then + milliseconds(10));
  const auto down = bench.sample();
  ASSERT_TRUE(down);
  EXPECT_EQ(down->stream, 0U);
  EXPECT_TRUE(button_of(*down).pressed);
  EXPECT_GE(down->received - button_of(*down).acquired, milliseconds(39));
  EXPECT_GE(button_of(*down).acquired, before - milliseconds(1));
  EXPECT_EQ(bench.source->health().state, SourceState::kStreaming);
  bench.line.key(BTN_0, 0, kernel_now());
  const auto up = bench.sample();
  ASSERT_TRUE(up);
  EXPECT_FALSE(button_of(*up).pressed);
  EXPECT_EQ(up->sequence, 1U);
  EXPECT_TRUE(bench.until([](const auto& h) { return h.state == SourceState::kReady; }));
  EXPECT_GT(bench.source->health().bytes, 0U);
}

TEST(FootSwitchSourceTest, TwoPressesWithin150MsCountOnceOnEachButton) {
  FootBench bench;
  const microseconds now = kernel_now();
  for (const int ms : {-600, -500, -380}) {
    bench.line.key(BTN_0, 1, now + milliseconds(ms));
    bench.line.key(BTN_0, 0, now + milliseconds(ms + 20));
  }
  bench.line.key(BTN_1, 1, now - milliseconds(590));
  std::vector<std::size_t> pressed(2);
  for (int i = 0; i < 5; ++i) {
    const auto got = bench.sample();
    ASSERT_TRUE(got);
    if (button_of(*got).pressed) ++pressed[got->stream];
  }
  EXPECT_TRUE(bench.is_quiet(milliseconds(30)));
  EXPECT_EQ(pressed, (std::vector<std::size_t>{2, 1}));
  EXPECT_EQ(bench.source->health().bad_messages["bounce"], 1U);
}

TEST(FootSwitchSourceTest, UnpluggedItSaysSoAndComesBackWithTheSameStreams) {
  FootBench bench;
  bench.line.key(BTN_0, 1, kernel_now());
  ASSERT_TRUE(bench.sample());
  bench.line.unplug();
  ASSERT_TRUE(bench.until([](const auto& h) { return h.state == SourceState::kWaiting; }));
  EXPECT_NE(bench.reports().find("hid:05f3:00ff: "), std::string::npos) << bench.reports();
  EXPECT_FALSE(bench.source->health().cause.empty());
  bench.line.plug();
  ASSERT_TRUE(bench.until([](const auto& h) { return h.state == SourceState::kReady; }));
  EXPECT_EQ(bench.source->health().reconnects, 1U);
  // The release while it was away is not known; the next press counts.
  bench.line.key(BTN_0, 0, kernel_now());
  std::this_thread::sleep_for(kPressesCountOnce);
  bench.line.key(BTN_0, 1, kernel_now());
  const auto again = bench.sample();
  ASSERT_TRUE(again);
  EXPECT_TRUE(button_of(*again).pressed);
  EXPECT_EQ(again->sequence, 1U);
}

TEST(FootSwitchSourceTest, AnUnpluggedInputDeviceIsNamedByTheKernelsError) {
  std::array<std::byte, kEvdevBytes> bytes{};
  const TcpTransfer none = read_input(FileDescriptor(), bytes);  // EBADF.
  ASSERT_TRUE(none.failure);
  EXPECT_STREQ(none.failure->cause, "error");
}

TEST(FootSwitchSourceTest, AfterALossTheKernelIsAskedForTheKeys) {
  FootBench bench;
  bench.line.key(BTN_0, 1, kernel_now());
  ASSERT_TRUE(bench.sample());
  bench.down = std::vector<std::uint8_t>(BTN_0 / 8 + 1);
  bench.down->back() = 1U << (BTN_1 % 8);  // The left one came up, the right one went down.
  bench.line.event({kernel_now(), EV_SYN, SYN_DROPPED, 0});
  bench.line.key(BTN_0, 1, kernel_now());
  std::vector<bool> now(2);
  for (int i = 0; i < 2; ++i) {
    const auto got = bench.sample();
    ASSERT_TRUE(got);
    now[got->stream] = button_of(*got).pressed;
  }
  EXPECT_EQ(now, (std::vector<bool>{false, true}));
  EXPECT_EQ(bench.source->health().bad_messages["kernel_drops"], 1U);
}

TEST(FootSwitchSourceTest, AKeyThatIsNoButtonIsNamedOnce) {
  FootBench bench;
  for (int i = 0; i < 3; ++i) bench.line.key(KEY_B, 1, kernel_now());
  EXPECT_TRUE(bench.is_quiet(milliseconds(50)));
  const std::string all = bench.reports();
  EXPECT_NE(all.find("KEY_B"), std::string::npos);
  EXPECT_EQ(all.find("KEY_B"), all.rfind("KEY_B"));
}

TEST(FootSwitchSourceTest, ImpossibleOptionsAreNamed) {
  FootSwitchOptions options;
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"at least one button"}));
  options.buttons = {{"left", BTN_0}, {"left", BTN_1}};
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"'left' twice"}));
  options.buttons = {{"left", BTN_0}, {"right", BTN_0}};
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"BTN_0 twice"}));
}

TEST(CanButtonSourceTest, ChangesOfBitsAreSamplesAndRepeatedFramesAreNot) {
  CanBench bench;
  bench.send(0x01);
  bench.send(0x01);
  bench.send(0x01, 0x80);
  const auto left = bench.sample();
  ASSERT_TRUE(left);
  EXPECT_EQ(left->stream, 0U);
  EXPECT_TRUE(button_of(*left).pressed);
  const auto right = bench.sample();
  ASSERT_TRUE(right);
  EXPECT_EQ(right->stream, 1U);
  bench.send(0x00, 0x80);
  const auto up = bench.sample();
  ASSERT_TRUE(up);
  EXPECT_FALSE(button_of(*up).pressed);
  EXPECT_TRUE(bench.is_quiet(milliseconds(30)));
}

TEST(CanButtonSourceTest, ShortAndDamagedFramesAreCountedByCause) {
  CanBench bench;
  bench.line.frame({.id = 0x18A, .size = 1, .data = {0x01}});
  ASSERT_TRUE(bench.sample()) << "the button in byte 0 is there";
  const std::array<std::byte, 7> torn{};
  bench.line.write(torn);
  bench.line.frame({.id = 0x77, .size = 8});
  EXPECT_TRUE(bench.until([](const auto& h) { return h.bad_messages.contains("malformed"); }));
  EXPECT_EQ(bench.source->health().bad_messages["short_frame"], 1U);
  EXPECT_NE(bench.reports().find("frame of 'right'"), std::string::npos) << bench.reports();
}

TEST(CanButtonSourceTest, BusOffIsALossWithWhatToDo) {
  CanBench bench;
  bench.line.frame({.id = CAN_ERR_BUSOFF, .error = true, .size = 8});
  EXPECT_TRUE(bench.until([](const auto& h) { return h.cause == "bus_off"; }));
  EXPECT_NE(bench.reports().find("termination"), std::string::npos) << bench.reports();
  EXPECT_TRUE(bench.until(
      [](const auto& h) { return h.state == SourceState::kReady && h.reconnects == 1; }));
}

TEST(CanButtonSourceTest, ABoxThatSendsAllTheTimeIsMissedWhenItStops) {
  CanBench bench(milliseconds(60));
  bench.send(0);
  EXPECT_TRUE(bench.until([](const auto& h) { return h.state == SourceState::kSilent; }));
  EXPECT_EQ(bench.source->health().cause, "silent");
  bench.send(0);
  EXPECT_TRUE(bench.until([](const auto& h) { return h.state == SourceState::kReady; }));
}

}  // namespace
}  // namespace nav::devices
