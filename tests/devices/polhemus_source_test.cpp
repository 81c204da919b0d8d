// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/polhemus_source.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <thread>

#include "devices/usb/libusb_link.hpp"
#include "tests/devices/source_bench.hpp"
#include "tests/devices/usb_rigs.hpp"
#include "tests/support/matchers.hpp"

/// The source meets the emulated tracker by USB/IP, without a kernel that has USB.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;

constexpr double kFloatMm = 1e-3;   ///< Rounding of a float in centimetres, up to 10 m.
constexpr double kFloatRad = 1e-5;  ///< Rounding of a quaternion of floats.

struct PolhemusBench : SourceBench<PolhemusSource> {
  explicit PolhemusBench(int stations = 1, std::uint32_t first_ms = 0)
      : emulator(emulated_liberty(stations, first_ms)) {
    options.bodies.clear();
    for (int station = 1; station <= stations; ++station) {
      options.bodies.push_back({.name = "Body" + std::to_string(station), .station = station});
    }
    options.times = quick_usb_times();
  }
  void start() {
    source = *PolhemusSource::create(options, "liberty", usbip_opener(emulator->server()), clock,
                                     diagnostics);
  }
  PolhemusEmulatedTracker& tracker() { return emulator->tracker(); }
  std::uint64_t bad(const std::string& cause) const {
    const auto health = source->health();
    const auto found = health.bad_messages.find(cause);
    return found == health.bad_messages.end() ? 0 : found->second;
  }
  /// Takes samples, of which each with a pose must be true, until \p done.
  bool until_true(const std::function<bool(const Sample&)>& done) {
    for (int i = 0; i < 5000; ++i) {
      const auto got = sample();
      if (!got) return false;
      expect_true(*got);
      if (done(*got)) return true;
    }
    return false;
  }
  void expect_true(const Sample& got) const {
    const auto& pose = std::get<PoseSample>(got.what).pose;
    EXPECT_EQ(pose.received, got.received);
    if (pose.status == TrackingStatus::kInvalid) {
      EXPECT_FALSE(pose.tracker_from_body.allFinite());
      return;
    }
    const Eigen::Matrix4d& matrix = pose.tracker_from_body;
    ASSERT_TRUE(matrix.allFinite());
    const double frame = std::round(matrix(0, 3) / kPolhemusStepMm);
    const int station = options.bodies[got.stream].station;
    const auto truth = polhemus_truth(station, static_cast<std::uint32_t>(frame));
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(matrix(i, 3), truth.position_mm[static_cast<std::size_t>(i)], kFloatMm);
    }
    const auto& [w, x, y, z] = truth.rotation_wxyz;
    const Eigen::Matrix3d turn = Eigen::Quaterniond(w, x, y, z).toRotationMatrix();
    EXPECT_LT((matrix.topLeftCorner<3, 3>() - turn).norm(), kFloatRad);
  }

  std::unique_ptr<PolhemusEmulator> emulator;
  PolhemusOptions options;
};

TEST(PolhemusSourceTest, GivesTheTruthInMillimetresWithTheDevicesClockAndCount) {
  PolhemusBench bench(3);
  bench.start();
  std::map<std::size_t, Sample> before;
  int count = 0;
  ASSERT_TRUE(bench.until_true([&](const Sample& got) {
    EXPECT_EQ(std::get<PoseSample>(got.what).pose.status, TrackingStatus::kOk);
    if (const auto last = before.find(got.stream); last != before.end()) {
      const auto frames = got.sequence - last->second.sequence;
      const auto passed = *got.device_time - *last->second.device_time;
      EXPECT_GE(frames, 1U);
      EXPECT_NEAR(std::chrono::duration<double>(passed).count(), static_cast<double>(frames) / 240,
                  0.0015)
          << "the device's clock counts milliseconds";
    }
    before.insert_or_assign(got.stream, got);
    return ++count == 300;
  })) << bench.reports();
  EXPECT_EQ(before.size(), 3U);
  EXPECT_TRUE(bench.tracker().is_in_centimetres());
  const auto commands = bench.tracker().commands();
  EXPECT_EQ(commands, (std::vector<std::string>{"p", "f1", "u1", "O*,8,9,11,3,7",
                                                "h*,1.0000,0.0000,0.0000", "c"}));
}

TEST(PolhemusSourceTest, StopsTheOutputWhenItEnds) {
  PolhemusBench bench;
  bench.start();
  ASSERT_TRUE(bench.sample());
  bench.source->stop();
  EXPECT_EQ(bench.source->next(bench.clock.now()).error().code, ErrorCode::kCancelled);
  for (int i = 0; i < 400 && bench.tracker().commands().back() != "p"; ++i) {
    std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_EQ(bench.tracker().commands().back(), "p");
}

/// A fault and its cause in the counts.
struct FaultCase {
  PolhemusFault fault;
  const char* cause;
};

TEST(PolhemusSourceTest, EachFaultIsCountedByItsCauseAndCostsItsFrameOnly) {
  PolhemusBench bench(2);
  bench.start();
  ASSERT_TRUE(bench.until_true([](const Sample&) { return true; })) << bench.reports();
  for (const FaultCase& one : {FaultCase{PolhemusFault::kMagic, "magic"},
                               {PolhemusFault::kSize, "size"},
                               {PolhemusFault::kCut, "cut"},
                               {PolhemusFault::kFrameNumber, "frame_number"},
                               {PolhemusFault::kNotFinite, "not_finite"},
                               {PolhemusFault::kNoRotation, "no_rotation"},
                               {PolhemusFault::kError, "device_error"},
                               {PolhemusFault::kDistortion, "distortion"},
                               {PolhemusFault::kLost, "lost_frames"},
                               {PolhemusFault::kEmpty, "empty"},
                               {PolhemusFault::kStall, "stall"},
                               {PolhemusFault::kOverflow, "overflow"},
                               {PolhemusFault::kProtocol, "transfer_error"}}) {
    const auto count = bench.bad(one.cause);
    bench.tracker().inject(one.fault, 1);
    ASSERT_TRUE(bench.until_true([&](const Sample&) { return bench.bad(one.cause) > count; }))
        << one.cause << "\n"
        << bench.reports();
    int good = 0;
    ASSERT_TRUE(bench.until_true([&](const Sample& got) {
      good += std::get<PoseSample>(got.what).pose.status == TrackingStatus::kOk;
      return good == 20;
    })) << one.cause;
  }
  EXPECT_EQ(bench.source->health().reconnects, 0U) << bench.reports();
  EXPECT_EQ(bench.bad("restart"), 0U);
  EXPECT_GE(bench.emulator->server().cleared_halts(), 1U);
}

TEST(PolhemusSourceTest, AFrameThatComesTwiceIsGivenOnceAndOneInTwoPartsIsWhole) {
  PolhemusBench bench;
  bench.start();
  ASSERT_TRUE(bench.sample());
  bench.tracker().inject(PolhemusFault::kRepeat, 3);
  bench.tracker().inject(PolhemusFault::kSplit, 5);
  std::optional<std::uint64_t> before;
  ASSERT_TRUE(bench.until_true([&](const Sample& got) {
    EXPECT_TRUE(!before || got.sequence > *before);
    before = got.sequence;
    return bench.source->health().repeats == 3 && *before > 60;
  })) << bench.reports();
  EXPECT_EQ(bench.bad("cut"), 0U);
  EXPECT_EQ(bench.bad("magic"), 0U);
}

TEST(PolhemusSourceTest, ADistortedFieldDegradesThePoseAboveTheLimit) {
  PolhemusBench bench;
  bench.start();
  ASSERT_TRUE(bench.sample());
  bench.tracker().inject(PolhemusFault::kDistortion, 1);
  ASSERT_TRUE(bench.until_true([](const Sample& got) {
    return std::get<PoseSample>(got.what).pose.status == TrackingStatus::kUnknown;
  }));
  EXPECT_NE(bench.reports().find("station 1 reports a distortion of 99, expected at most 0"),
            std::string::npos)
      << bench.reports();
  PolhemusBench tolerant;
  tolerant.options.distortion_limit = 99;
  tolerant.start();
  ASSERT_TRUE(tolerant.sample());
  tolerant.tracker().inject(PolhemusFault::kDistortion, 5);
  int good = 0;
  ASSERT_TRUE(tolerant.until_true([&](const Sample& got) {
    EXPECT_EQ(std::get<PoseSample>(got.what).pose.status, TrackingStatus::kOk);
    return ++good == 30;
  }));
}

TEST(PolhemusSourceTest, ADeviceThatWasSwitchedOffAndOnIsAskedForCentimetresAgain) {
  PolhemusBench bench(2);
  bench.start();
  int count = 0;
  ASSERT_TRUE(bench.until_true([&](const Sample&) { return ++count == 100; }));
  bench.tracker().inject(PolhemusFault::kRestart, 1);
  // The device goes on in inches: not one pose of those may come through.
  ASSERT_TRUE(bench.until_true([&](const Sample&) { return bench.bad("restart") == 1; }))
      << bench.reports();
  EXPECT_TRUE(bench.tracker().is_in_centimetres());
  EXPECT_EQ(std::ranges::count(bench.tracker().commands(), "u1"), 2);
  EXPECT_EQ(bench.source->health().reconnects, 0U);
}

TEST(PolhemusSourceTest, TheClockOfTheDeviceGoesOnWhenItWraps) {
  constexpr std::uint32_t kBeforeWrapMs = std::numeric_limits<std::uint32_t>::max() - 600;
  PolhemusBench bench(1, kBeforeWrapMs);
  bench.start();
  std::optional<DeviceTime> before;
  ASSERT_TRUE(bench.until_true([&](const Sample& got) {
    EXPECT_TRUE(!before || *got.device_time > *before);
    before = got.device_time;
    return *before > DeviceTime(milliseconds(std::int64_t{1} << 32) + milliseconds(100));
  })) << bench.reports();
  EXPECT_EQ(bench.bad("restart"), 0U);
  EXPECT_EQ(bench.bad("frame_number"), 0U);
}

TEST(PolhemusSourceTest, AnUnpluggedDeviceComesBack) {
  PolhemusBench bench;
  bench.start();
  ASSERT_TRUE(bench.sample());
  bench.emulator->server().unplug();
  ASSERT_TRUE(bench.until([](const auto& h) { return h.cause == "not_exported"; }))
      << bench.reports();
  bench.emulator->server().replug();
  ASSERT_TRUE(bench.until([](const auto& h) { return h.reconnects == 1; })) << bench.reports();
  EXPECT_TRUE(bench.until_true([](const Sample&) { return true; }));
}

TEST(PolhemusSourceTest, TransfersThatAllFailAreALossWithTheirCause) {
  PolhemusBench bench;
  bench.start();
  ASSERT_TRUE(bench.sample());
  bench.tracker().inject(PolhemusFault::kStall, UsbSource::kMostFailures);
  ASSERT_TRUE(bench.until([](const auto& h) { return h.cause == "stall"; })) << bench.reports();
  EXPECT_NE(bench.reports().find("8 transfers in a row ended with stall"), std::string::npos);
  EXPECT_TRUE(bench.until([](const auto& h) { return h.reconnects == 1; })) << bench.reports();
}

TEST(PolhemusSourceTest, NamesAStationThatIsNotDeclared) {
  PolhemusBench bench(2);
  bench.options.bodies.pop_back();
  bench.start();
  ASSERT_TRUE(bench.until_true([](const Sample& got) { return got.stream == 0; }));
  ASSERT_TRUE(bench.until([&](const auto&) {
    return bench.reports().find("station 2 sends, but belongs to none of the bodies") !=
           std::string::npos;
  }));
}

TEST(PolhemusSourceTest, RejectsOptionsOutOfRange) {
  const auto with = [](const std::function<void(PolhemusOptions&)>& change) {
    PolhemusOptions options{.bodies = {{}}};
    change(options);
    return validate(options);
  };
  const auto bad = [&](const std::function<void(PolhemusOptions&)>& change,
                       std::initializer_list<std::string> words) {
    EXPECT_TRUE(test::rejects(with(change), ErrorCode::kUsage, words));
  };
  EXPECT_TRUE(test::has_value(with([](auto&) {})));
  bad([](auto& o) { o.bodies.clear(); }, {"at least one body"});
  bad([](auto& o) { o.bodies[0].name.clear(); }, {"a name of each body"});
  bad([](auto& o) { o.bodies[0].station = 17; }, {"1 to 16", "17"});
  bad([](auto& o) { o.bodies.push_back(o.bodies[0]); }, {"name of its own", "Probe"});
  bad([](auto& o) { o.bodies.push_back({.name = "Reference", .station = 1}); },
      {"station of its own", "1 twice"});
  bad([](auto& o) { o.hemisphere = {0, 0, 0}; }, {"hemisphere"});
  bad([](auto& o) { o.distortion_limit = -1; }, {"distortion", "-1"});
  bad([](auto& o) { o.times.lost = o.times.silence; }, {"time of loss"});
}

/// No machine of a developer has a device of these numbers.
TEST(LibusbLinkTest, ADeviceThatIsNotThereIsNamed) {
  const auto opened = open_usb({.vendor = 0xFFFE, .product = 0xFFFD, .serial = "A1"});
  ASSERT_FALSE(opened.has_value());
  EXPECT_NE(opened.error().message.find("usb:fffe:fffd:A1"), std::string::npos)
      << opened.error().message;
}

}  // namespace
}  // namespace nav::devices
