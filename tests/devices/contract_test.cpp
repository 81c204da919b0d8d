// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <ctime>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <netinet/in.h>
#include <sys/socket.h>
#include <thread>

#include "devices/can/can_arm_emulator.hpp"
#include "devices/ndi/ndi_emulator.hpp"
#include "devices/ndi/ndi_source.hpp"
#include "devices/openigtlink/openigtlink_server.hpp"
#include "devices/openigtlink/openigtlink_source.hpp"
#include "tests/devices/button_rigs.hpp"
#include "tests/devices/camera_rigs.hpp"
#include "tests/devices/can_arm_models.hpp"
#include "tests/devices/igtl_wire.hpp"
#include "tests/devices/toy_source.hpp"
#include "tests/devices/usb_rigs.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// The rules that hold for every device (docs/how-to-add.md). A rig is a device with its
/// other side: appear() makes it deliver, vanish() takes the other side away, hush() lets it stay
/// connected but say nothing.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Duration kSurely = seconds(20);  ///< Wait for what is certain to happen.

struct Rig {
  MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  std::unique_ptr<PolledSource> source;
};

template <class Made>
void keep(Rig& rig, Made made) {
  ASSERT_TRUE(test::has_value(made));
  rig.source = *std::move(made);
}

/// Tries again for a while: another program may have a port for a moment.
bool had(const std::function<bool()>& get) {
  for (int i = 0; i < 200; ++i) {
    if (get()) return true;
    std::this_thread::sleep_for(milliseconds(25));
  }
  return false;
}

/// A server of OpenIGTLink that sends a pose every few milliseconds.
struct OpenIgtLinkRig : Rig {
  OpenIgtLinkRig() {
    // A port that is free now, for the server that comes later.
    port = (*OpenIgtLinkServer::start({}, diagnostics))->port();
    OpenIgtLinkOptions options;
    options.port = port;
    options.streams = {{"ProbeToTracker", StreamKind::kPoses, ToolRole::kProbe}};
    options.first_retry = options.longest_retry = milliseconds(20);
    options.silence = milliseconds(100);
    keep(*this, OpenIgtLinkSource::create(options, clock, diagnostics));
  }
  ~OpenIgtLinkRig() { vanish(); }
  void appear() {
    ASSERT_TRUE(had([&] {
      auto started = OpenIgtLinkServer::start({.port = port}, diagnostics);
      if (started) server = *std::move(started);
      return started.has_value();
    }));
    talks = true;
    talker = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        if (talks) {
          server->send({.type = "TRANSFORM", .device = "ProbeToTracker"},
                       test::content_of(IgtlTransform::from(test::translation(1, 2, 3))));
        }
        std::this_thread::sleep_for(milliseconds(3));
      }
    });
  }
  void vanish() {
    talker = {};
    server.reset();
  }
  void hush() { talks = false; }

  std::uint16_t port = 0;
  std::unique_ptr<OpenIgtLinkServer> server;
  std::atomic<bool> talks{false};
  std::jthread talker;
};

template <bool kTcp>
struct NdiRig : Rig {
  NdiRig() {
    const std::string rom = std::string("NDI\0", 4) + "\xc9" + std::string(1, '\0') + "\x01" +
                            std::string(1, '\0') + "\xc8";
    std::ofstream(folder / "tool.rom", std::ios::binary) << rom;
    NdiEmulatedOptions emulated;
    emulated.tools.push_back({.rom = rom});
    emulated.see = [](std::size_t, std::uint32_t) {
      return NdiToolReading{.presence = NdiPresence::kMeasured, .rotation_wxyz = {1, 0, 0, 0}};
    };
    NdiEmulatorLine line{.tcp = kTcp};
    if (!kTcp) line.link = folder / "ttyNDI";
    emulator = *NdiEmulator::start(emulated, line);
    NdiOptions options;
    options.streams = {{{.name = "Probe", .rom = folder / "tool.rom"}, ToolRole::kProbe}};
    options.first_retry = options.longest_retry = milliseconds(20);
    options.break_time = milliseconds(5);
    options.reset_wait = milliseconds(20);
    options.silence = milliseconds(100);
    options.lost = milliseconds(400);
    keep(*this, NdiSource::create(options,
                                  kTcp ? *make_ndi_tcp("127.0.0.1", emulator->port())
                                       : make_ndi_serial(emulator->path()),
                                  clock, diagnostics));
    emulator->unplug();
  }
  void appear() {
    ASSERT_TRUE(had([&] { return emulator->replug().has_value(); }));
  }
  void vanish() { emulator->unplug(); }
  void hush() { emulator->inject(NdiEmulatedFault::kSilence, 1'000'000); }

  test::TemporaryFolder folder;
  std::unique_ptr<NdiEmulator> emulator;
};

struct CanArmRig : Rig {
  CanArmRig() {
    emulator = CanArmEmulator::start(six_joint_arm(),
                                     [](std::uint64_t) { return std::vector<double>(6, 0.1); });
    emulator->unplug();
    CanArmOptions options;
    options.arm = six_joint_arm();
    options.first_retry = options.longest_retry = milliseconds(20);
    options.lost = milliseconds(400);
    keep(*this, CanArmSource::create(options, "emulated", emulator->opener(), clock, diagnostics));
  }
  void appear() { emulator->replug(); }
  void vanish() { emulator->unplug(); }
  void hush() {
    for (std::size_t i = 0; i < 6; ++i) emulator->silence(i);
  }

  std::unique_ptr<CanArmEmulator> emulator;
};

/// A foot that taps all the time: on a foot switch, or on buttons of a CAN bus.
template <class SourceKind>
struct ButtonRig : Rig {
  static constexpr bool kFoot = std::is_same_v<SourceKind, FootSwitchSource>;
  ButtonRig() : line(kFoot ? SOCK_STREAM : SOCK_SEQPACKET) {
    const ButtonTimes times{.streaming = milliseconds(300),
                            .first_retry = milliseconds(20),
                            .longest_retry = milliseconds(50)};
    line.unplug();
    if constexpr (kFoot) {
      keep(*this, FootSwitchSource::create({.buttons = {{"left", BTN_0}}, .times = times}, "pedal",
                                           line.opener(), clock, diagnostics));
    } else {
      keep(*this,
           CanButtonSource::create({.buttons = {{.name = "left", .frame = 0x18A}}, .times = times},
                                   "can0", line.opener(), clock, diagnostics));
    }
    foot = std::jthread([this](const std::stop_token& stop) {
      for (bool down = true; !stop.stop_requested(); down = !down) {
        if (taps) tap(down);
        // Presses that follow more quickly count once.
        std::this_thread::sleep_for(milliseconds(80));
      }
    });
  }
  void tap(bool down) {
    if constexpr (kFoot) {
      line.key(BTN_0, down ? 1 : 0, kernel_now());
    } else {
      line.frame({.id = 0x18A, .size = 1, .data = {static_cast<std::uint8_t>(down ? 1 : 0)}});
    }
  }
  void appear() {
    line.plug();
    taps = true;
  }
  void vanish() { line.unplug(); }
  void hush() { taps = false; }

  ButtonLine line;
  std::atomic<bool> taps{false};
  std::jthread foot;
};

/// A camera that tracks markers, or grabs the screen of a scanner.
template <class SourceKind>
struct CameraRig : Rig {
  CameraRig() {
    const ImageTimes times{.silence = milliseconds(100),
                           .lost = milliseconds(400),
                           .first_retry = milliseconds(20),
                           .longest_retry = milliseconds(50)};
    camera.unplug();
    if constexpr (std::is_same_v<SourceKind, MarkerSource>) {
      keep(*this,
           MarkerSource::create({.streams = {{"Probe"}}, .times = times}, "camera", camera.opener(),
                                std::make_unique<FixedFinder>(1), clock, diagnostics));
    } else {
      keep(*this, FrameGrabberSource::create({.times = times}, "grabber", camera.opener(), clock,
                                             diagnostics));
    }
  }
  void appear() { camera.plug(); }
  void vanish() { camera.unplug(); }
  void hush() { camera.hush(); }

  FakeCamera camera;
};

/// A tracker on USB, by a USB/IP server.
struct PolhemusRig : Rig {
  PolhemusRig() : emulator(emulated_liberty(1)) {
    emulator->server().unplug();
    keep(*this, PolhemusSource::create({.bodies = {{}}, .times = quick_usb_times()}, "liberty",
                                       usbip_opener(emulator->server()), clock, diagnostics));
  }
  void appear() { emulator->server().replug(); }
  void vanish() { emulator->server().unplug(); }
  void hush() { emulator->tracker().hush(true); }

  std::unique_ptr<PolhemusEmulator> emulator;
};

/// A probe on USB, by a USB/IP server.
struct IntersonRig : Rig {
  IntersonRig() : emulator(emulated_see_more()) {
    emulator->server().unplug();
    keep(*this,
         IntersonSource::create(see_more_options(), "probe",
                                usbip_opener(emulator->server(), kSeeMoreId), clock, diagnostics));
  }
  void appear() { emulator->server().replug(); }
  void vanish() { emulator->server().unplug(); }
  void hush() { emulator->probe().hush(true); }

  std::unique_ptr<IntersonEmulator> emulator;
};

/// The device of docs/how-to-add.md.
struct ToyRig : Rig {
  ToyRig() {
    source = std::make_unique<ToySource>([this] { return toy.open(); }, clock, diagnostics);
  }
  void appear() { toy.appear(); }
  void vanish() { toy.vanish(); }
  void hush() { toy.hush(); }

  Toy toy;
};

template <class T>
class DeviceContractTest : public ::testing::Test {
 protected:
  /// Takes samples until one comes.
  [[nodiscard]] Result<Sample> sample() {
    const Timestamp end = rig_.clock.now() + kSurely;
    for (;;) {
      auto got = rig_.source->next(rig_.clock.now() + milliseconds(20));
      if (got || rig_.clock.now() > end) return got;
    }
  }
  [[nodiscard]] bool until_health(const std::function<bool(const SourceHealth&)>& done) {
    const Timestamp end = rig_.clock.now() + kSurely;
    while (rig_.clock.now() < end) {
      (void)rig_.source->next(rig_.clock.now() + milliseconds(10));
      if (done(rig_.source->health())) return true;
    }
    return false;
  }
  [[nodiscard]] std::string reports() const {
    std::string all;
    for (const auto& entry : rig_.diagnostics.entries()) all += entry.message + "\n";
    return all;
  }
  T rig_;
};
using Rigs = ::testing::Types<OpenIgtLinkRig, NdiRig<true>, NdiRig<false>, CanArmRig,
                              ButtonRig<FootSwitchSource>, ButtonRig<CanButtonSource>,
                              CameraRig<MarkerSource>, CameraRig<FrameGrabberSource>, PolhemusRig,
                              IntersonRig, ToyRig>;
TYPED_TEST_SUITE(DeviceContractTest, Rigs);

double processor_time_s() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// A client that tries a local port at which nothing listens may get this port as its own.
TEST(TcpSocketTest, AConnectionToItselfIsNone) {
  const FileDescriptor socket(::socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  ASSERT_EQ(::bind(socket.get(), any, sizeof address), 0);
  address.sin_port = htons(bound_port(socket));
  ASSERT_EQ(::connect(socket.get(), any, sizeof address), 0);
  const auto failure = finish_tcp_connect(socket);
  ASSERT_TRUE(failure);
  EXPECT_STREQ(failure->cause, "no_listener");
}

TYPED_TEST(DeviceContractTest, NothingByTheDeadlineIsATimeout) {
  auto& source = *this->rig_.source;
  ASSERT_FALSE(source.streams().empty());
  for (const StreamInfo& stream : source.streams()) EXPECT_FALSE(stream.name.empty());
  for (int i = 0; i < 5; ++i) {
    const Timestamp deadline = this->rig_.clock.now() + milliseconds(5);
    const auto got = source.next(deadline);
    ASSERT_FALSE(got.has_value());
    EXPECT_EQ(got.error().code, ErrorCode::kTimeout);
    EXPECT_GE(this->rig_.clock.now(), deadline);
  }
  EXPECT_EQ(source.next(Timestamp{}).error().code, ErrorCode::kTimeout) << "a deadline gone by";
  EXPECT_NE(source.health().state, SourceState::kStreaming);
}

TYPED_TEST(DeviceContractTest, SamplesComeInOrder) {
  this->rig_.appear();
  Timestamp before{};
  std::map<std::size_t, std::uint64_t> sequences;
  for (int i = 0; i < 30; ++i) {
    const auto got = this->sample();
    ASSERT_TRUE(test::has_value(got)) << this->reports();
    ASSERT_LT(got->stream, this->rig_.source->streams().size());
    EXPECT_GE(got->received, before);
    EXPECT_LE(got->received, this->rig_.clock.now());
    before = got->received;
    const auto [found, first] = sequences.emplace(got->stream, got->sequence);
    if (!first) {
      EXPECT_GT(got->sequence, found->second);
      found->second = got->sequence;
    }
  }
  EXPECT_TRUE(this->until_health([](const auto& h) {
    return h.state == SourceState::kStreaming && h.bytes > 0;
  })) << this->reports();
  EXPECT_EQ(this->rig_.source->health().reconnects, 0U) << this->reports();
}

TYPED_TEST(DeviceContractTest, StopEndsNextAndStaysStopped) {
  this->rig_.appear();
  ASSERT_TRUE(this->sample().has_value());
  this->rig_.hush();
  std::jthread stopper([this] {
    std::this_thread::sleep_for(milliseconds(30));
    this->rig_.source->stop();
    this->rig_.source->stop();
  });
  for (;;) {  // Samples that were on their way come first.
    const auto got = this->rig_.source->next(Timestamp::max());
    if (got) continue;
    EXPECT_EQ(got.error().code, ErrorCode::kCancelled);
    break;
  }
  EXPECT_EQ(this->rig_.source->next(Timestamp::max()).error().code, ErrorCode::kCancelled);
  EXPECT_EQ(this->rig_.source->health().state, SourceState::kEnded);
}

TYPED_TEST(DeviceContractTest, StopBeforeTheFirstNext) {
  this->rig_.source->stop();
  EXPECT_EQ(this->rig_.source->next(Timestamp::max()).error().code, ErrorCode::kCancelled);
}

TYPED_TEST(DeviceContractTest, APeerThatVanishesIsALossWithACauseAndComesBack) {
  this->rig_.appear();
  ASSERT_TRUE(this->sample().has_value()) << this->reports();
  this->rig_.vanish();
  ASSERT_TRUE(this->until_health([](const auto& h) { return h.state == SourceState::kWaiting; }))
      << this->reports();
  EXPECT_FALSE(this->rig_.source->health().cause.empty());
  const std::size_t warnings = this->rig_.diagnostics.entries().size();
  EXPECT_GT(warnings, 0U);
  // A message that stays the same while the peer is away is said once or twice, not with every
  // attempt.
  for (int i = 0; i < 20; ++i)
    (void)this->rig_.source->next(this->rig_.clock.now() + milliseconds(20));
  EXPECT_LE(this->rig_.diagnostics.entries().size(), warnings + 2) << this->reports();
  this->rig_.appear();
  ASSERT_TRUE(this->until_health([](const auto& h) {
    return h.state == SourceState::kStreaming && h.reconnects > 0;
  })) << this->reports();
  EXPECT_TRUE(this->sample().has_value());
}

TYPED_TEST(DeviceContractTest, SilenceIsNotStreamingAndCostsNoProcessor) {
  this->rig_.appear();
  ASSERT_TRUE(this->sample().has_value()) << this->reports();
  this->rig_.hush();
  ASSERT_TRUE(this->until_health([](const auto& h) {
    return h.state == SourceState::kSilent || h.state == SourceState::kWaiting ||
           h.state == SourceState::kReady;
  })) << this->reports();
  const double begin = processor_time_s();
  const Timestamp end = this->rig_.clock.now() + milliseconds(300);
  while (this->rig_.clock.now() < end) (void)this->rig_.source->next(end);
  EXPECT_LT(processor_time_s() - begin, 0.15) << "half of the time would be a busy loop";
}

}  // namespace
}  // namespace nav::devices
