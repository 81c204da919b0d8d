// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/session_recorder.hpp"

#include <csignal>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <thread>

#include "io/mcap/device_recording.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/scripted_source.hpp"
#include "tests/support/test_data.hpp"

namespace nav::session {
namespace {

using test::at_ms;
using test::ScriptedSource;

LiveDevice a_device(const std::string& id) {
  LiveDevice device;
  device.options.id = id;
  device.source = std::make_shared<ScriptedSource>(ScriptedSource::usual());
  return device;
}

Sample pose_sample(std::uint64_t number) {
  const int ms = static_cast<int>(number);
  return {.stream = 0,
          .sequence = number,
          .received = at_ms(ms),
          .what = PoseSample{test::pose_at(ms, {0.1 * ms, 0, 0})}};
}

Sample image_sample(std::uint64_t number, int side) {
  UltrasoundImage image = test::image_at(number, static_cast<int>(number));
  image.pixels = Image2d<std::uint8_t>(
      side, side, std::vector<std::uint8_t>(static_cast<std::size_t>(side * side), 7));
  return {.stream = 2, .sequence = number, .received = image.received, .what = std::move(image)};
}

class SessionRecorderTest : public ::testing::Test {
 protected:
  std::unique_ptr<SessionRecorder> start(std::size_t most_waiting = std::size_t{64} << 20) {
    auto recorder = SessionRecorder::start(
        {.path = path_, .most_waiting = most_waiting, .facts = {{"version", "test"}}}, clock_,
        diagnostics_);
    EXPECT_TRUE(test::has_value(recorder));
    EXPECT_TRUE(test::has_value((*recorder)->add_devices({a_device("a"), a_device("b")})));
    return *std::move(recorder);
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "recording.mcap";
  MonotonicClock clock_;
  CollectingDiagnostics diagnostics_;
};

TEST_F(SessionRecorderTest, WritesWhatSeveralThreadsDeliver) {
  constexpr std::uint64_t kSamples = 500;
  auto recorder = start();
  {
    std::jthread first([&] {
      for (std::uint64_t i = 0; i < kSamples; ++i) recorder->record(0, pose_sample(i));
    });
    std::jthread second([&] {
      for (std::uint64_t i = 0; i < kSamples; ++i) recorder->record(1, image_sample(i, 32));
    });
  }
  ASSERT_TRUE(test::has_value(recorder->finish()));
  const RecordingAccount account = recorder->account();
  EXPECT_EQ(account.received, 2 * kSamples);
  EXPECT_EQ(account.written, 2 * kSamples);
  const RecordingAccount progress = recorder->progress();
  EXPECT_EQ(progress.received, account.received);
  EXPECT_EQ(progress.written, account.written);
  EXPECT_EQ(progress.path, account.path);
  EXPECT_TRUE(account.balanced());
  EXPECT_EQ(account.bytes, std::filesystem::file_size(path_));
  const auto recording = io::mcap::DeviceRecording::open(path_);
  ASSERT_TRUE(test::has_value(recording));
  EXPECT_TRUE(recording->is_finished());
  EXPECT_EQ(recording->session().at("version"), "test");
  ASSERT_EQ(recording->devices().size(), 2U);
  EXPECT_EQ(recording->devices()[1].id, "b");
  auto source = recording->source(0);
  ASSERT_TRUE(test::has_value(source));
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const auto sample = (*source)->next(Timestamp::max());
    ASSERT_TRUE(test::has_value(sample));
    EXPECT_EQ(sample->sequence, i);
    EXPECT_EQ(std::get<PoseSample>(sample->what).pose.tracker_from_body,
              std::get<PoseSample>(pose_sample(i).what).pose.tracker_from_body);
  }
  EXPECT_TRUE(diagnostics_.entries().empty());
}

TEST_F(SessionRecorderTest, CountsWhatItsQueueCannotHold) {
  auto recorder = start(std::size_t{1} << 20);
  // An image of 2 MB never fits into a queue of 1 MB.
  for (std::uint64_t i = 0; i < 3; ++i) recorder->record(0, image_sample(i, 1500));
  recorder->record(0, pose_sample(3));
  ASSERT_TRUE(test::has_value(recorder->finish()));
  const RecordingAccount account = recorder->account();
  EXPECT_EQ(account.dropped.at("queue_full"), 3U);
  EXPECT_EQ(account.written, 1U);
  EXPECT_TRUE(account.balanced());
  ASSERT_EQ(diagnostics_.entries().size(), 1U) << "said once";
  EXPECT_NE(diagnostics_.entries()[0].message.find("samples are lost"), std::string::npos);
  recorder->record(0, pose_sample(4));
  EXPECT_EQ(recorder->account().dropped.at("stopped"), 1U);
}

TEST_F(SessionRecorderTest, AFullDiskEndsTheRecordingAndSaysSo) {
  // The programs do the same: the limit is then an error of a write, not the end of the process.
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  auto recorder = start();
  rlimit small = before;
  small.rlim_cur = 300'000;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  for (std::uint64_t i = 0; i < 200; ++i) recorder->record(0, image_sample(i, 100));
  const auto finished = recorder->finish();
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().code, ErrorCode::kIo);
  const RecordingAccount account = recorder->account();
  EXPECT_FALSE(account.stopped.empty());
  EXPECT_GT(account.lost(), 0U);
  EXPECT_TRUE(account.balanced());
  const auto entries = diagnostics_.entries();
  ASSERT_FALSE(entries.empty());
  EXPECT_NE(entries[0].message.find("nothing more is recorded"), std::string::npos);
  // The samples in the file can be read.
  const auto recording = io::mcap::DeviceRecording::open(path_, {.read_all = true});
  ASSERT_TRUE(test::has_value(recording));
  EXPECT_GT(recording->samples(), 0U);
}

TEST_F(SessionRecorderTest, DoesNotOverwriteARecording) {
  { const auto recorder = start(); }
  const auto again = SessionRecorder::start({.path = path_}, clock_, diagnostics_);
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().message.find("recording.mcap"), std::string::npos);
}

}  // namespace
}  // namespace nav::session
