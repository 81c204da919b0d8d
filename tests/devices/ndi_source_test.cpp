// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_source.hpp"

#include <atomic>
#include <cmath>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <set>
#include <thread>

#include "devices/ndi/ndi_emulator.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// The source against the emulator, over real pseudo terminals and real sockets.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Duration kCertainly = seconds(20);  ///< Wait for what is certain to happen.

/// A tool definition that no other number has.
std::string small_rom(unsigned number) {
  std::string rom("NDI\0", 4);
  const unsigned sum = number % 256 + number / 256 + 200;
  rom += static_cast<char>(sum % 256);
  rom += static_cast<char>(sum / 256);
  rom += static_cast<char>(number % 256);
  rom += static_cast<char>(number / 256);
  rom += static_cast<char>(200);
  return rom;
}

/// A tool at (number, tool, -1000) mm, where number is that of the frame.
NdiToolReading at_its_place(std::size_t tool, std::uint32_t number) {
  NdiToolReading reading{.presence = NdiPresence::kMeasured, .rotation_wxyz = {1, 0, 0, 0}};
  reading.translation_mm = {number % 1000 * 1.0, static_cast<double>(tool), -1000};
  reading.error_mm = 0.25;
  return reading;
}

/// An emulator, a source and what they report.
struct Bench {
  explicit Bench(bool over_tcp) { line.tcp = over_tcp; }

  void add_wireless(unsigned number) {
    const std::string file = "tool" + std::to_string(number) + ".rom";
    std::ofstream(folder / file, std::ios::binary) << small_rom(number);
    emulated.tools.push_back({.rom = small_rom(number)});
    options.streams.push_back(
        {.tool = {.name = "T" + std::to_string(number), .rom = folder / file}});
  }
  void add_wired(unsigned port) {
    emulated.tools.push_back({.port = port});
    options.streams.push_back(
        {.tool = {.name = "W" + std::to_string(port), .place = NdiPlace{.port = port}}});
  }
  void start() {
    if (!emulated.see) emulated.see = at_its_place;
    if (!line.tcp) line.link = folder / "ttyNDI";
    auto started = NdiEmulator::start(emulated, line, plan);
    ASSERT_TRUE(test::has_value(started));
    emulator = *std::move(started);
    options.first_retry = milliseconds(20);
    options.longest_retry = milliseconds(50);
    options.break_time = milliseconds(5);
    options.reset_wait = milliseconds(20);
    options.silence = milliseconds(100);
    options.lost = milliseconds(400);
    auto transport =
        line.tcp ? *make_ndi_tcp("127.0.0.1", emulator->port()) : make_ndi_serial(emulator->path());
    auto made = NdiSource::create(options, std::move(transport), clock, diagnostics);
    ASSERT_TRUE(test::has_value(made));
    source = *std::move(made);
  }
  Result<Sample> next() { return source->next(clock.now() + kCertainly); }
  /// Takes samples until something is true of the newest.
  [[nodiscard]] bool until(const std::function<bool(const Sample&)>& done) {
    const Timestamp end = clock.now() + kCertainly;
    while (clock.now() < end) {
      const auto sample = source->next(clock.now() + milliseconds(20));
      if (done(sample ? *sample : Sample{.stream = 9999})) return true;
    }
    return false;
  }
  [[nodiscard]] bool until_account(const std::function<bool(const NdiHealth&)>& done) {
    return until([&](const Sample&) { return done(source->account()); });
  }
  [[nodiscard]] bool until_tracked() {
    return until([](const Sample& sample) { return sample.stream != 9999; });
  }
  [[nodiscard]] bool was_reported(const std::string& piece) const {
    for (const auto& entry : diagnostics.entries()) {
      if (entry.message.find(piece) != std::string::npos) return true;
    }
    return false;
  }
  [[nodiscard]] std::string all_reports() const {
    std::string all;
    for (const auto& entry : diagnostics.entries()) all += entry.message + "\n";
    return all;
  }

  test::TemporaryFolder folder;
  MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  NdiEmulatedOptions emulated;
  NdiEmulatorLine line;
  NdiFaultPlan plan;
  NdiOptions options;
  std::unique_ptr<NdiEmulator> emulator;
  std::unique_ptr<NdiSource> source;
};

/// Over a pseudo terminal (false) and by TCP (true).
class NdiSourceTest : public ::testing::TestWithParam<bool> {
 protected:
  Bench bench_{GetParam()};
};

const PoseSample& pose_of(const Sample& sample) { return std::get<PoseSample>(sample.what); }

TEST_P(NdiSourceTest, GivesThePosesOfSixteenTools) {
  for (unsigned i = 0; i < 16; ++i) bench_.add_wireless(i);
  bench_.start();
  std::set<std::size_t> seen;
  for (int i = 0; i < 64; ++i) {
    const auto sample = bench_.next();
    ASSERT_TRUE(test::has_value(sample)) << bench_.all_reports();
    seen.insert(sample->stream);
    const PoseSample& pose = pose_of(*sample);
    EXPECT_EQ(pose.pose.status, TrackingStatus::kOk);
    EXPECT_EQ(pose.pose.tracker_from_body(1, 3), static_cast<double>(sample->stream));
    EXPECT_EQ(pose.pose.tracker_from_body(0, 3), static_cast<double>(sample->sequence));
    EXPECT_EQ(pose.tracker_error_mm, 0.25);
    EXPECT_EQ(pose.pose.received, sample->received);
    ASSERT_TRUE(sample->device_time);
    EXPECT_EQ(sample->device_time->time_since_epoch().count(),
              static_cast<std::int64_t>(sample->sequence) * 1'000'000'000 / 60);
  }
  EXPECT_EQ(seen.size(), 16U);
  const SourceHealth health = bench_.source->health();
  EXPECT_EQ(health.state, SourceState::kStreaming);
  EXPECT_EQ(health.firmware, "Polaris Control Firmware, EMULATED");
  EXPECT_EQ(health.serial, "P4-00000");
  EXPECT_GT(health.bytes, 0U);
  EXPECT_TRUE(health.bad_messages.empty());
  EXPECT_EQ(bench_.source->account().form, NdiForm::kBx2);
}

TEST_P(NdiSourceTest, AsksInTheFormThatTheTrackerKnows) {
  bench_.emulated.knows_bx2 = false;
  bench_.add_wireless(1);
  bench_.start();
  ASSERT_TRUE(bench_.until_tracked()) << bench_.all_reports();
  EXPECT_EQ(bench_.source->account().form, NdiForm::kBx);
  Bench old(GetParam());
  old.emulated.knows_bx2 = old.emulated.knows_bx = false;
  old.add_wireless(1);
  old.start();
  ASSERT_TRUE(old.until_tracked()) << old.all_reports();
  EXPECT_EQ(old.source->account().form, NdiForm::kTx);
}

TEST_P(NdiSourceTest, GivesNoDeviceTimeWhereTheCounterIsNotKnown) {
  bench_.emulated.firmware = "Aurora Control Firmware";
  bench_.add_wired(2);
  bench_.start();
  for (std::uint64_t i = 0; i < 5; ++i) {
    const auto sample = bench_.next();
    ASSERT_TRUE(test::has_value(sample)) << bench_.all_reports();
    EXPECT_EQ(sample->device_time, std::nullopt);
    EXPECT_EQ(sample->sequence, i) << "its own count";
  }
}

/// ndicapi#40, scikit-surgerynditracker#50: a wrong .rom or port stops everything.
TEST_P(NdiSourceTest, AWrongToolCostsOnlyItself) {
  for (unsigned i = 0; i < 5; ++i) bench_.add_wireless(i);
  bench_.add_wired(1);
  bench_.add_wired(3);
  std::filesystem::remove(bench_.options.streams[0].tool.rom);
  std::ofstream(bench_.options.streams[1].tool.rom) << "no tool definition at all";
  bench_.emulated.tools[2].rom = small_rom(77);  // The tracker rejects what is uploaded.
  bench_.emulated.tools[3].wrong_memory = true;
  bench_.options.streams[5].tool.place = NdiPlace{.port = 9};
  bench_.start();
  std::set<std::size_t> seen;
  ASSERT_TRUE(bench_.until([&](const Sample& sample) {
    if (sample.stream != 9999) seen.insert(sample.stream);
    return seen.size() >= 2 && bench_.source->account().samples[4] > 10;
  })) << bench_.all_reports();
  EXPECT_EQ(seen, (std::set<std::size_t>{4, 6}));
  const NdiHealth health = bench_.source->account();
  EXPECT_NE(health.tool_faults[0].find("found no such file"), std::string::npos);
  EXPECT_NE(health.tool_faults[1].find("found another file"), std::string::npos);
  EXPECT_NE(health.tool_faults[2].find("error 13"), std::string::npos);
  EXPECT_NE(health.tool_faults[3].find("error 13"), std::string::npos);
  EXPECT_EQ(health.tool_faults[4], "");
  EXPECT_NE(health.tool_faults[5].find("no usable tool is at port 9"), std::string::npos);
  EXPECT_EQ(health.tool_faults[6], "");
  EXPECT_TRUE(bench_.was_reported("T0: ")) << bench_.all_reports();
  EXPECT_TRUE(bench_.was_reported("W1: ")) << bench_.all_reports();
  EXPECT_EQ(bench_.source->health().cause, "tool");
}

TEST_P(NdiSourceTest, SaysThatNoToolCanBeTrackedAndTriesAgain) {
  bench_.add_wireless(1);
  std::filesystem::remove(bench_.options.streams[0].tool.rom);
  bench_.start();
  ASSERT_TRUE(
      bench_.until_account([](const auto& health) { return health.losses.contains("setup"); }));
  EXPECT_EQ(bench_.source->health().state, SourceState::kWaiting);
  std::ofstream(bench_.options.streams[0].tool.rom, std::ios::binary) << small_rom(1);
  EXPECT_TRUE(bench_.until_tracked()) << bench_.all_reports();
}

TEST_P(NdiSourceTest, GivesMissingAndOutOfVolumePosesTheirStatus) {
  bench_.emulated.see = [](std::size_t tool, std::uint32_t number) {
    NdiToolReading reading = at_its_place(tool, number);
    if (number % 4 == 1) reading = {.presence = NdiPresence::kMissing};
    if (number % 4 == 2) reading.out_of_volume = true;
    if (number % 4 == 3) reading.partly_out_of_volume = true;
    return reading;
  };
  bench_.add_wireless(1);
  bench_.start();
  for (int i = 0; i < 12; ++i) {
    const auto sample = bench_.next();
    ASSERT_TRUE(test::has_value(sample)) << bench_.all_reports();
    const RawPose& pose = pose_of(*sample).pose;
    const bool missing = sample->sequence % 4 == 1;
    EXPECT_EQ(pose.tracker_from_body.allFinite(), !missing);
    EXPECT_EQ(pose.status, missing                     ? TrackingStatus::kOccluded
                           : sample->sequence % 4 == 0 ? TrackingStatus::kOk
                                                       : TrackingStatus::kOutOfVolume);
    EXPECT_EQ(pose_of(*sample).tracker_error_mm.has_value(), !missing);
  }
}

TEST_P(NdiSourceTest, NeverGivesOneFrameTwice) {
  bench_.add_wireless(1);
  bench_.plan = {.seed = 7, .rate = 0.5, .kinds = {NdiEmulatedFault::kRepeat}};
  bench_.start();
  std::uint64_t newest = 0;
  for (int i = 0; i < 50; ++i) {
    const auto sample = bench_.next();
    ASSERT_TRUE(test::has_value(sample)) << bench_.all_reports();
    EXPECT_GT(sample->sequence, newest);
    newest = sample->sequence;
  }
  EXPECT_GT(bench_.source->account().repeats, 5U);
  EXPECT_GT(bench_.source->health().repeats, 5U);
  EXPECT_TRUE(bench_.source->health().bad_messages.empty());
}

TEST_P(NdiSourceTest, BrokenRepliesCostOnlyThemselves) {
  using enum NdiEmulatedFault;
  for (const NdiForm form : {NdiForm::kBx2, NdiForm::kBx, NdiForm::kTx}) {
    Bench bench(GetParam());
    bench.add_wireless(1);
    bench.add_wireless(2);
    bench.options.form = form;
    bench.plan = {
        .seed = 11, .rate = 0.2, .kinds = {kBadCrc, kSplit, kTruncated, kGarbage, kRepeat}};
    bench.start();
    std::array<std::uint64_t, 2> newest{};
    for (int i = 0; i < 120; ++i) {
      const auto sample = bench.next();
      ASSERT_TRUE(test::has_value(sample)) << bench.all_reports();
      const auto& pose = pose_of(*sample).pose;
      EXPECT_EQ(pose.status, TrackingStatus::kOk);
      EXPECT_EQ(pose.tracker_from_body(0, 3), static_cast<double>(sample->sequence));
      EXPECT_EQ(pose.tracker_from_body(1, 3), static_cast<double>(sample->stream));
      EXPECT_GT(sample->sequence, newest[sample->stream]);
      newest[sample->stream] = sample->sequence;
    }
    const NdiHealth health = bench.source->account();
    EXPECT_EQ(health.connections, 1U) << bench.all_reports();
    EXPECT_FALSE(health.bad_replies.empty());
  }
}

TEST_P(NdiSourceTest, BrokenRepliesDuringSetupAreAskedForAgain) {
  using enum NdiEmulatedFault;
  for (const NdiEmulatedFault fault : {kBadCrc, kSplit, kGarbage}) {
    Bench bench(GetParam());
    bench.add_wireless(1);
    bench.options.baud = 9600;  // COMM is never asked for twice.
    bench.start();
    bench.emulator->inject(fault, 2);
    ASSERT_TRUE(bench.until_tracked()) << bench.all_reports();
    EXPECT_EQ(bench.source->account().connections, 1U);
  }
}

TEST_P(NdiSourceTest, ReportsSilenceAndComesBack) {
  bench_.add_wireless(1);
  bench_.start();
  ASSERT_TRUE(bench_.until_tracked()) << bench_.all_reports();
  bench_.emulator->inject(NdiEmulatedFault::kSilence, 2);
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.silences == 1; }));
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.state == NdiState::kTracking; }));
  EXPECT_EQ(bench_.source->account().connections, 1U);
  bench_.emulator->inject(NdiEmulatedFault::kSilence, 6);
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.losses.contains("silent"); }))
      << bench_.all_reports();
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.connections == 2; }))
      << bench_.all_reports();
  EXPECT_EQ(bench_.source->health().reconnects, 1U);
  EXPECT_TRUE(bench_.until_tracked());
}

TEST_P(NdiSourceTest, SetsTheTrackerUpAgainAfterAReset) {
  bench_.add_wireless(1);
  bench_.start();
  ASSERT_TRUE(bench_.until_tracked()) << bench_.all_reports();
  bench_.emulator->inject(NdiEmulatedFault::kReset);
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.connections == 2; }))
      << bench_.all_reports();
  EXPECT_EQ(bench_.source->account().losses.at("reset"), 1U);
  ASSERT_TRUE(bench_.until_tracked());
  bench_.emulator->reset();
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return h.connections == 3; }))
      << bench_.all_reports();
}

TEST_P(NdiSourceTest, ComesBackWhenTheDeviceIsPluggedInAgain) {
  bench_.add_wireless(1);
  bench_.start();
  for (std::uint64_t round = 1; round <= 3; ++round) {
    ASSERT_TRUE(bench_.until_account([&](const auto& h) { return h.connections == round; }))
        << bench_.all_reports();
    ASSERT_TRUE(bench_.until_tracked());
    bench_.emulator->unplug();
    const std::string gone = GetParam() ? "no_listener" : "absent";
    ASSERT_TRUE(bench_.until_account([&](const auto& h) {
      return h.losses.contains(gone) && h.losses.at(gone) >= round;
    })) << bench_.all_reports();
    EXPECT_EQ(bench_.source->health().state, SourceState::kWaiting);
    ASSERT_TRUE(test::has_value(bench_.emulator->replug()));
  }
  ASSERT_TRUE(bench_.until_tracked()) << bench_.all_reports();
}

TEST_P(NdiSourceTest, AToolThatIsPluggedOutAndInComesBack) {
  bench_.add_wireless(1);
  bench_.add_wired(2);
  bench_.start();
  const auto give = [&](std::size_t stream) {
    return bench_.until([&](const Sample& sample) { return sample.stream == stream; });
  };
  ASSERT_TRUE(give(1)) << bench_.all_reports();
  bench_.emulator->plug(1, false);
  ASSERT_TRUE(bench_.until_account([](const auto& h) { return !h.tool_faults[1].empty(); }));
  EXPECT_TRUE(bench_.was_reported("W2: it was unplugged"));
  ASSERT_TRUE(give(0)) << "the other tool goes on";
  bench_.emulator->plug(1, true);
  ASSERT_TRUE(give(1)) << bench_.all_reports();
  ASSERT_TRUE(give(0));
  EXPECT_EQ(bench_.source->account().connections, 1U);
  EXPECT_EQ(bench_.source->account().tool_faults[1], "");
}

TEST_P(NdiSourceTest, StopsFromAnotherThreadInEveryState) {
  for (const int state : {0, 1, 2}) {
    Bench bench(GetParam());
    bench.add_wireless(1);
    bench.start();
    if (state > 0) {
      ASSERT_TRUE(bench.until_tracked()) << bench.all_reports();
    }
    if (state == 1) bench.emulator->inject(NdiEmulatedFault::kSilence, 1000);
    if (state == 2) bench.emulator->unplug();
    std::atomic<bool> ended{false};
    std::thread reader([&] {
      for (;;) {
        const auto sample = bench.source->next(bench.clock.now() + kCertainly);
        if (!sample && sample.error().code == ErrorCode::kCancelled) break;
      }
      ended = true;
    });
    std::this_thread::sleep_for(milliseconds(30));
    bench.source->stop();
    bench.source->stop();
    reader.join();
    EXPECT_TRUE(ended);
    EXPECT_EQ(bench.source->health().state, SourceState::kEnded);
  }
}

INSTANTIATE_TEST_SUITE_P(Lines, NdiSourceTest, ::testing::Bool(),
                         [](const auto& line) { return line.param ? "Tcp" : "Pty"; });

TEST(NdiSerialTest, LowersABaudRateThatTheTrackerDoesNotHave) {
  Bench bench(false);
  bench.add_wireless(1);
  bench.options.baud = 1228739;
  bench.emulated.most_baud = 115200;
  bench.start();
  ASSERT_TRUE(bench.until_tracked()) << bench.all_reports();
  EXPECT_TRUE(bench.was_reported("error 06")) << bench.all_reports();
}

TEST(NdiSerialTest, SaysWhyAPortCannotBeOpened) {
  const test::TemporaryFolder folder;
  MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  std::ofstream(folder / "file") << "text";
  const auto cause_of = [&](const std::string& path) {
    NdiOptions options;
    options.streams.push_back({.tool = {.name = "Probe"}});
    const auto source = *NdiSource::create(options, make_ndi_serial(path), clock, diagnostics);
    EXPECT_EQ(source->next(clock.now() + milliseconds(20)).error().code, ErrorCode::kTimeout);
    return source->health().cause;
  };
  EXPECT_EQ(cause_of(folder / "absent"), "absent");
  EXPECT_EQ(cause_of(folder / "file"), "not_serial");
}

double thread_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

TEST(NdiSerialTest, WaitsWithoutABusyLoop) {
  Bench bench(false);
  bench.add_wireless(1);
  bench.start();
  ASSERT_TRUE(bench.until_tracked());
  bench.emulator->unplug();
  const double before = thread_seconds();
  const Timestamp end = bench.clock.now() + milliseconds(500);
  while (bench.clock.now() < end) (void)bench.source->next(end);
  constexpr double kMostSeconds = 0.1;  // A busy loop takes 0.5 s of the processor.
  EXPECT_LT(thread_seconds() - before, kMostSeconds);
}

TEST(NdiOptionsTest, NamesWhatCannotBeUsed) {
  NdiOptions options;
  EXPECT_FALSE(validate(options));
  options.streams.push_back({.tool = {.name = "Probe", .place = NdiPlace{1, 0}}});
  EXPECT_TRUE(test::has_value(validate(options)));
  options.streams.push_back({.tool = {.name = "Needle", .place = NdiPlace{1, 0}}});
  EXPECT_NE(validate(options).error().message.find("Probe and Needle at port 1"),
            std::string::npos);
  options.streams[1].tool = {.name = "Probe"};
  EXPECT_FALSE(validate(options));
  options.streams.pop_back();
  options.baud = 9601;
  EXPECT_NE(validate(options).error().message.find("9600, 14400"), std::string::npos);
}

}  // namespace
}  // namespace nav::devices
