// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <optional>
#include <sstream>
#include <sys/stat.h>
#include <thread>

#include "app/verbs/replay.hpp"
#include "app/verbs/simulate/simulate.hpp"
#include "io/mcap/device_recorder.hpp"
#include "io/sequence.hpp"
#include "io/sequence_writer.hpp"
#include "session/recorded_session.hpp"
#include "session/recorded_setup.hpp"
#include "sim/session/simulated_session.hpp"
#include "sim/simulated_source.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// A replay without a survey does not know the future: its first images are the same bytes whether
/// the recording ends there or goes on.
namespace nav::app {
namespace {

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Images of a replay without a survey, in order.
std::vector<std::string> replayed(const std::filesystem::path& recording, SessionConfig config,
                                  const std::filesystem::path& out) {
  config.source.recording = recording;
  config.source.survey = false;
  config.source.skip_bad_frames = true;
  config.output.folder = out;
  config.output.width = 64;
  config.output.height = 48;
  config.output.threads = 1;
  config.output.step_voxels = 2;
  Console console(false);
  const auto done = run_replay(config, std::nullopt, console);
  EXPECT_TRUE(test::has_value(done)) << recording;
  std::vector<std::string> images;
  for (int i = 0;; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "replay_%05d.png", i);
    if (!std::filesystem::exists(out / name)) return images;
    images.push_back(bytes_of(out / name));
  }
}

/// Copy of a recording that ends after the first frames. moved_from: first frame whose calibration
/// lies 5 mm beside that of the frames before; absent: none.
void cut(const std::filesystem::path& from, std::int64_t frames, const std::filesystem::path& to,
         std::optional<std::int64_t> moved_from = {}) {
  auto reader = io::SequenceReader::open(from);
  ASSERT_TRUE(test::has_value(reader));
  auto writer = io::SequenceWriter::create(to, reader->header());
  ASSERT_TRUE(test::has_value(writer));
  for (std::int64_t i = 0; i < frames; ++i) {
    auto frame = reader->read(i);
    ASSERT_TRUE(test::has_value(frame));
    if (moved_from && i >= *moved_from) {
      std::istringstream numbers(frame->fields.at("ImageToProbeTransform"));
      std::ostringstream moved;
      moved.precision(17);
      double number = 0;
      for (int n = 0; numbers >> number; ++n) moved << (n == 3 ? number + 5 : number) << ' ';
      frame->fields["ImageToProbeTransform"] = moved.str();
    }
    ASSERT_TRUE(test::has_value(writer->append(*frame)));
  }
  ASSERT_TRUE(test::has_value(writer->finish()));
}

void expect_prefix(const std::vector<std::string>& first, const std::vector<std::string>& whole,
                   const std::string& what) {
  ASSERT_GT(first.size(), 0u) << what;
  ASSERT_LE(first.size(), whole.size()) << what;
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_TRUE(first[i] == whole[i]) << what << ": image " << i;
  }
}

/// The shorter recordings have the file name of the whole one, which every image shows. most: the
/// whole recording has no more frames; 0: all of the file.
void expect_prefixes(const std::filesystem::path& recording, const SessionConfig& config,
                     const std::vector<std::int64_t>& lengths, std::int64_t most = 0) {
  const test::TemporaryFolder folder;
  const auto cut_after = [&](std::int64_t frames) {
    const auto place = folder / std::to_string(frames);
    std::filesystem::create_directories(place);
    cut(recording, frames, place / recording.filename());
    return replayed(place / recording.filename(), config, place / "out");
  };
  const auto whole = most > 0 ? cut_after(most) : replayed(recording, config, folder / "whole");
  ASSERT_GT(whole.size(), 2u) << recording;
  for (const std::int64_t frames : lengths) {
    expect_prefix(cut_after(frames), whole,
                  recording.string() + ", " + std::to_string(frames) + " frames");
  }
}

SimulateOptions simulated(const test::TemporaryFolder& folder) {
  SimulateOptions options;
  options.out = folder / "sweep.igs.mha";
  options.ct = folder / "ct.mha";
  options.columns = 160;
  options.rows = 120;
  options.duration_s = 3;
  options.frame_rate_hz = 10;
  return options;
}

TEST(PrefixTest, ASimulatedSweepOfAConvexProbe) {
  const test::TemporaryFolder folder;
  const SimulateOptions options = simulated(folder);
  Console console(false);
  ASSERT_TRUE(test::has_value(run_simulate(options, console)));
  SessionConfig config;
  config.ct.path = options.ct;
  // Before and after the outline is known, and without a placement.
  expect_prefixes(options.out, config, {3, 12, 25});
  // With a temporal offset, images wait for later poses.
  config.source.temporal_offset_ms = -30;
  config.placement.ct_from_reference = Eigen::Matrix4d::Identity();
  expect_prefixes(options.out, config, {7});
}

TEST(PrefixTest, AnotherCalibrationChangesNothingBeforeIt) {
  const test::TemporaryFolder folder;
  const SimulateOptions options = simulated(folder);
  Console console(false);
  ASSERT_TRUE(test::has_value(run_simulate(options, console)));
  SessionConfig config;
  config.ct.path = options.ct;
  std::filesystem::create_directories(folder / "whole");
  std::filesystem::create_directories(folder / "moved");
  const auto name = options.out.filename();
  constexpr std::int64_t kMovedFrom = 20;
  cut(options.out, kMovedFrom, folder / "whole" / name);
  cut(options.out, 28, folder / "moved" / name, kMovedFrom);
  const auto whole = replayed(folder / "whole" / name, config, folder / "whole-out");
  const auto moved = replayed(folder / "moved" / name, config, folder / "moved-out");
  ASSERT_GT(whole.size(), 2u);
  ASSERT_GE(moved.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_TRUE(whole[i] == moved[i]) << i;
  const std::string report = bytes_of(folder / "moved-out" / "report.json");
  for (const char* piece : {"frame 20: ImageToProbe: expected the calibration of frame 0",
                            "5 mm away at a corner; a probe has one calibration"}) {
    EXPECT_NE(report.find(piece), std::string::npos) << piece;
  }
  // A survey reads the recording before the replay, and stops at the first bad frame.
  config.source.recording = folder / "moved" / name;
  config.output.folder = folder / "surveyed-out";
  EXPECT_TRUE(test::rejects(run_replay(config, std::nullopt, console), ErrorCode::kMalformedData,
                            {"frame 20: ImageToProbe", "frame 0", "8 of 28 frames are bad"}));
}

TEST(PrefixTest, ARecordingFromAPipeReplaysAsItComes) {
  const test::TemporaryFolder folder;
  SimulateOptions options = simulated(folder);
  options.duration_s = 1;
  Console console(false);
  for (const bool compressed : {false, true}) {
    options.compress = compressed;
    ASSERT_TRUE(test::has_value(run_simulate(options, console)));
    SessionConfig config;
    config.ct.path = options.ct;
    const std::string name = compressed ? "compressed" : "raw";
    const auto from_file = replayed(options.out, config, folder / ("file-" + name));
    std::filesystem::create_directories(folder / name);
    const auto pipe = folder / name / options.out.filename();
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    const auto out = folder / ("pipe-" + name);
    const std::string bytes = bytes_of(options.out);
    std::atomic<bool> early{false};  // The first image was there before the last bytes were.
    std::thread writer([&] {
      std::ofstream file(pipe, std::ios::binary);
      const std::size_t most = bytes.size() - 1000;
      file.write(bytes.data(), static_cast<std::streamsize>(most));
      file.flush();
      for (int i = 0; i < 3000 && !early; ++i) {
        early = std::filesystem::exists(out / "replay_00000.png");
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
      file.write(bytes.data() + most, static_cast<std::streamsize>(bytes.size() - most));
    });
    const auto from_pipe = replayed(pipe, config, out);
    writer.join();
    EXPECT_TRUE(early) << name;
    ASSERT_EQ(from_pipe.size(), from_file.size());
    for (std::size_t i = 0; i < from_pipe.size(); ++i) EXPECT_TRUE(from_pipe[i] == from_file[i]);
  }
}

TEST(PrefixTest, ALinearProbeANeedleAndFaults) {
  const test::TemporaryFolder folder;
  Console console(false);
  SimulateOptions needle = simulated(folder);
  needle.duration_s = 2;
  needle.needle = "bevel";
  SimulateOptions linear = needle;
  linear.needle = "none";
  linear.family = "neck";
  SimulateOptions faults = needle;
  faults.faults = "0.01";
  for (const SimulateOptions& options : {needle, linear, faults}) {
    ASSERT_TRUE(test::has_value(run_simulate(options, console)));
    SessionConfig config;
    config.ct.path = options.ct;
    config.appearance.preset = "ct-bone";
    if (options.needle != "none") config.source.needle_frame = "NeedleTip";
    auto reader = io::SequenceReader::open(options.out);
    ASSERT_TRUE(test::has_value(reader));
    const std::int64_t frames = reader->header().frame_count;
    expect_prefixes(options.out, config, {5, frames * 2 / 3});
  }
}

/// Records a simulated session as its devices give it. Returns the sizes of the file at the ends of
/// its chunks.
std::vector<std::uintmax_t> record(const std::filesystem::path& path) {
  sim::SimulatedSessionOptions options;
  options.duration_s = 2;
  options.probe.columns = 120;
  options.probe.rows = 90;
  options.needle.emplace();
  const auto simulation = sim::SimulatedSession::create(options);
  EXPECT_TRUE(test::has_value(simulation));
  const auto source = sim::source_of(*simulation);
  auto recorder = io::mcap::DeviceRecorder::create(path);
  EXPECT_TRUE(test::has_value(recorder));
  session::SessionSetup setup;
  setup.calibration = ProbeCalibration{simulation->probe_from_image()};
  setup.body_from_tip = simulation->needle()->hub_from_needle().matrix();
  EXPECT_TRUE(test::has_value(
      (*recorder)->add_metadata(session::kSetupMetadata, session::facts_of(setup))));
  const auto device = (*recorder)->add_device("devices", source->streams());
  EXPECT_TRUE(test::has_value(device));
  std::vector<std::uintmax_t> ends;
  constexpr Deadline kNever = Deadline::max();
  for (auto sample = source->next(kNever); sample; sample = source->next(kNever)) {
    EXPECT_TRUE(test::has_value((*recorder)->record(*device, *sample)));
    const auto counts = (*recorder)->counts();
    if (counts.chunks > ends.size()) ends.push_back(counts.bytes_written);
  }
  EXPECT_TRUE(test::has_value((*recorder)->finish()));
  return ends;
}

TEST(PrefixTest, ARecordingOfDevicesThatEndsAfterAnyChunk) {
  const test::TemporaryFolder folder;
  SimulateOptions patient = simulated(folder);
  patient.duration_s = 0.5;
  Console console(false);
  ASSERT_TRUE(test::has_value(run_simulate(patient, console)));
  SessionConfig config;
  config.ct.path = patient.ct;
  const auto recording = folder / "session.mcap";
  const auto ends = record(recording);
  ASSERT_GT(ends.size(), 10u);
  const auto whole = replayed(recording, config, folder / "whole");
  ASSERT_GT(whole.size(), 10u);
  std::size_t before = 0;
  for (const std::size_t chunk : {ends.size() / 4, ends.size() / 2, ends.size() - 2}) {
    const auto place = folder / std::to_string(chunk);
    std::filesystem::create_directories(place);
    std::filesystem::copy_file(recording, place / recording.filename());
    std::filesystem::resize_file(place / recording.filename(), ends[chunk]);
    const auto first = replayed(place / recording.filename(), config, place / "out");
    expect_prefix(first, whole, "chunk " + std::to_string(chunk));
    EXPECT_GT(first.size(), before);
    before = first.size();
  }
}

TEST(PrefixTest, ARecordingOfDevicesFromAPipeIsRejectedWithTheReason) {
  const test::TemporaryFolder folder;
  const auto pipe = folder / "session.mcap";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  session::SourceOptions source;
  source.recording = pipe;
  CollectingDiagnostics diagnostics;
  EXPECT_TRUE(test::rejects(session::RecordedSession::open(source, diagnostics), ErrorCode::kIo,
                            {"session.mcap: expected a file", "index", "found a pipe"}));
}

/// Recordings of the test data.
struct KnownRecording {
  std::string config;               ///< Below plus-sequences/config.
  std::string tracker = "Tracker";  ///< Frame of its poses.
  std::string unplayable = {};      ///< The reason, as the message says it; empty: it plays.
};

const std::string kNwire = "PlusDeviceSet_NwirePhantomFreehand_vtkVolumeReconstructorTest2.xml";
const std::string kFcal = "PlusDeviceSet_fCal_Sim_VolumeReconstruction.xml";

/// Every file of plus-sequences/sequences, by name. Without poses of a probe nothing can be placed.
std::map<std::string, KnownRecording> known_recordings() {
  const std::string no_pose = "expected frames that place Probe in Tracker";
  std::map<std::string, KnownRecording> known{
      {"SpinePhantomFreehand.igs.mha",
       {"PlusDeviceSet_VolumeReconstructionOnly_SpinePhantom_NN_MEAN.xml"}},
      {"BoneUltrasound_L14.igs.mha", {"BoneUltrasound_L14_config.xml"}},
      {"NwirePhantomFreehand.igs.mha", {kNwire}},
      {"NwirePhantomFreehand.igs.nrrd", {kNwire}},
      {"NwirePhantomFreehandCropped.igs.mha", {kNwire}},
      {"fCal_Test_Calibration_3NWires.igs.mha", {kFcal}},
      {"fCal_Test_Validation_3NWires.igs.mha", {kFcal}},
      {"USTC_3NWires_ProbeTranslation.igs.mha", {"BoneUltrasound_L14_config.xml", "StepperHome"}},
      {"TransformInterpolationTest.igs.mha", {kNwire}},
      {"outputPlusTransverseProcessEnhancerTest.igs.mha", {kNwire}}};
  for (const char* file :
       {"BkCurvilinearRfData.igs.mhd", "BkCurvilinearScanConvertedData.igs.mha",
        "ColorNrrdSample.igs.nrrd", "NrrdSample.igs.nrrd", "ReferenceToRASCalibration.igs.mha",
        "SegmentationTest_BKMedical_RandomStepperMotionData2_Trimmed.igs.mha",
        "SyntheticTrackerBuffer20.igs.mha", "SyntheticVideoBuffer20.igs.mha",
        "TimestampFilteringTest.igs.mha", "UltrasonixCurvilinearBrightnessData.igs.mha",
        "UltrasonixCurvilinearScanConvertedDataGroundTruth.igs.mha"}) {
    known[file] = {.config = kNwire, .unplayable = no_pose};
  }
  return known;
}

TEST(PrefixTest, EveryRecordingOfTheTestData) {
  SONDE_REQUIRE_DATA(ct, "ct-abdomen-totalseg/example_ct.nii.gz");
  SONDE_REQUIRE_DATA(sequences, "plus-sequences/sequences");
  constexpr std::int64_t kMost = 24;
  std::size_t found = 0;
  const auto known = known_recordings();
  for (const auto& entry : std::filesystem::directory_iterator(sequences)) {
    const std::string name = entry.path().filename();
    if (name.find(".igs.") == std::string::npos) continue;
    ++found;
    ASSERT_TRUE(known.contains(name)) << name << ": say whether it plays";
    const KnownRecording& recording = known.at(name);
    SessionConfig config;
    config.source.tracker_frame = recording.tracker;
    config.ct.path = ct;
    config.source.plus_config = test::data_dir() / "plus-sequences/config" / recording.config;
    if (!recording.unplayable.empty()) {
      const test::TemporaryFolder folder;
      config.source.recording = entry.path();
      config.source.survey = false;
      config.output.folder = folder / "out";
      Console console(false);
      EXPECT_TRUE(test::rejects(run_replay(config, std::nullopt, console), ErrorCode::kNotFound,
                                {name, recording.unplayable}));
      continue;
    }
    auto reader = io::SequenceReader::open(entry.path());
    ASSERT_TRUE(test::has_value(reader)) << name;
    const std::int64_t whole = std::min(reader->header().frame_count, kMost);
    config.appearance.preset = "ct-bone";  // Is not fitted to the CT, which takes time.
    expect_prefixes(entry.path(), config, {std::max<std::int64_t>(1, whole / 3)}, whole);
  }
  EXPECT_EQ(found, known.size());
}

TEST(PrefixTest, ARealSweepOverALeg) {
  SONDE_REQUIRE_DATA(ct, "ct-abdomen-totalseg/example_ct.nii.gz");
  SONDE_REQUIRE_DATA(sweep, "bone-ultrabones/legpass.igs.mha");
  SessionConfig config;
  config.ct.path = ct;
  config.source.plus_config = sweep.parent_path() / "plus.xml";
  config.appearance.preset = "ct-bone";
  expect_prefixes(sweep, config, {4, 15}, 24);
}

}  // namespace
}  // namespace nav::app
