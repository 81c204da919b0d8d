// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// A recording of devices gives, on the virtual clock, what its devices gave.
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>

#include "io/mcap/device_recorder.hpp"
#include "session/recorded_session.hpp"
#include "session/recorded_setup.hpp"
#include "sim/session/simulated_session.hpp"
#include "sim/simulated_source.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::session {
namespace {

/// Hands samples on and records them.
class TappedSource final : public Source {
 public:
  TappedSource(std::shared_ptr<Source> source, io::mcap::DeviceRecorder* recorder,
               std::size_t device)
      : source_(std::move(source)), recorder_(recorder), device_(device) {}
  [[nodiscard]] const std::vector<StreamInfo>& streams() const override {
    return source_->streams();
  }
  Result<Sample> next(Deadline deadline) override {
    auto sample = source_->next(deadline);
    if (sample) {
      // Stamps of a device whose clock began elsewhere and is 80 ppm fast.
      const auto ns = static_cast<double>(sample->received.time_since_epoch().count()) * 1.00008;
      sample->device_time = DeviceTime(std::chrono::nanoseconds(static_cast<std::int64_t>(ns)) +
                                       std::chrono::hours(400'000));
      if (recorder_ != nullptr) {
        EXPECT_TRUE(test::has_value(recorder_->record(device_, *sample)));
      }
    }
    return sample;
  }
  void stop() noexcept override { source_->stop(); }

 private:
  std::shared_ptr<Source> source_;
  io::mcap::DeviceRecorder* recorder_;
  std::size_t device_;
};

TEST(DeviceReplayTest, IsTheSessionThatWasRecordedToTheLastBit) {
  sim::SimulatedSessionOptions options;
  options.seed = 5;
  options.duration_s = 3;
  options.probe.columns = 120;
  options.probe.rows = 90;
  options.needle.emplace();
  const auto simulation = sim::SimulatedSession::create(options);
  ASSERT_TRUE(test::has_value(simulation));
  auto poses = std::make_shared<sim::SimulatedSource>();
  poses->add("Probe", ToolRole::kProbe, simulation->probe_poses());
  poses->add("Reference", ToolRole::kReference, simulation->reference_poses());
  poses->add("Needle", ToolRole::kNeedle, simulation->needle_poses());
  auto images = std::make_shared<sim::SimulatedSource>();
  images->add("Image", simulation->frames());

  const test::TemporaryFolder folder;
  const auto path = folder / "recording.mcap";
  auto recorder = io::mcap::DeviceRecorder::create(path);
  ASSERT_TRUE(test::has_value(recorder));
  SessionSetup setup;
  setup.calibration = ProbeCalibration{simulation->probe_from_image()};
  setup.body_from_tip = simulation->needle()->hub_from_needle().matrix();
  setup.navigator.frame_period.reset();
  setup.navigator.needle_period.reset();
  setup.images = QueuePolicy::kLossless;
  setup.learn_outline = false;
  ASSERT_TRUE(test::has_value((*recorder)->add_metadata(kSetupMetadata, facts_of(setup))));
  CollectingDiagnostics diagnostics;
  Session session(setup, diagnostics);
  const std::vector<std::pair<std::string, std::shared_ptr<Source>>> devices{{"tracker", poses},
                                                                             {"scanner", images}};
  for (const auto& [id, source] : devices) {
    const auto number = (*recorder)->add_device(id, source->streams());
    ASSERT_TRUE(test::has_value(number));
    session.add(std::make_shared<TappedSource>(source, recorder->get(), *number));
  }
  for (;;) {
    const auto next = session.next_arrival();
    ASSERT_TRUE(test::has_value(next));
    if (!*next) break;
    ASSERT_TRUE(test::has_value(session.advance_to(**next)));
  }
  session.finish();
  ASSERT_TRUE(test::has_value((*recorder)->finish()));
  const std::string log = session.log().text();
  EXPECT_GT(std::count(log.begin(), log.end(), '\n'), 30);

  SourceOptions source;
  source.recording = path;
  auto recorded = RecordedSession::open(source, diagnostics);
  ASSERT_TRUE(test::has_value(recorded));
  EXPECT_EQ(recorded->total_images(), simulation->frame_count());
  for (int run = 0; run < 3; ++run) {
    ASSERT_TRUE(test::has_value(recorded->play({})));
    EXPECT_TRUE(recorded->log().text() == log) << run;
    recorded->navigator().finish();
    for (const auto& account : recorded->session().accounts()) {
      EXPECT_TRUE(account.ledger.balanced()) << account.info.name;
      EXPECT_GT(account.ledger.received(), 0U) << account.info.name;
    }
    EXPECT_EQ(recorded->frames_read(), simulation->frame_count());
    ASSERT_TRUE(test::has_value(recorded->rewind()));
  }
}

TEST(DeviceReplayTest, ADamagedSetupIsNotReplacedByDefaults) {
  const test::TemporaryFolder folder;
  const auto path = folder / "recording.mcap";
  {
    auto recorder = io::mcap::DeviceRecorder::create(path);
    ASSERT_TRUE(test::has_value(recorder));
    ASSERT_TRUE(test::has_value((*recorder)->add_device("a", {{"Image", StreamKind::kImages}})));
    SessionSetup setup;
    setup.body_from_tip = Eigen::Matrix4d::Identity();
    ASSERT_TRUE(test::has_value((*recorder)->add_metadata(kSetupMetadata, facts_of(setup))));
    ASSERT_TRUE(test::has_value((*recorder)->finish()));
  }
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  for (std::size_t at = 0; (at = bytes.find("needle_body_from_tip", at)) != std::string::npos;
       ++at) {
    bytes[at] ^= 1;
  }
  file.clear();
  file.seekp(0);
  file << bytes;
  file.close();
  SourceOptions source;
  source.recording = path;
  source.plus_config = folder / "plus.xml";
  std::ofstream(source.plus_config)
      << "<PlusConfiguration><CoordinateDefinitions><Transform From=\"Image\" To=\"Probe\" "
         "Matrix=\"0.2 0 0 0 0 0.2 0 0 0 0 0.2 0 0 0 0 1\"/></CoordinateDefinitions>"
         "</PlusConfiguration>";
  CollectingDiagnostics diagnostics;
  EXPECT_TRUE(test::rejects(RecordedSession::open(source, diagnostics), ErrorCode::kMalformedData,
                            {"sonde.setup"}));
}

}  // namespace
}  // namespace nav::session
