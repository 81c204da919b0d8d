// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <sstream>
#include <sys/stat.h>
#include <thread>

#include "app/verbs/replay.hpp"
#include "app/verbs/simulate/simulate.hpp"
#include "io/sequence.hpp"
#include "io/sequence_writer.hpp"
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

/// The shorter recordings have the file name of the whole one, which every image shows.
void expect_prefixes(const std::filesystem::path& recording, const SessionConfig& config,
                     const std::vector<std::int64_t>& lengths) {
  const test::TemporaryFolder folder;
  const auto whole = replayed(recording, config, folder / "whole");
  ASSERT_GT(whole.size(), 2u) << recording;
  for (const std::int64_t frames : lengths) {
    const auto place = folder / std::to_string(frames);
    std::filesystem::create_directories(place);
    cut(recording, frames, place / recording.filename());
    const auto first = replayed(place / recording.filename(), config, place / "out");
    ASSERT_GT(first.size(), 0u) << recording << ", " << frames << " frames";
    ASSERT_LE(first.size(), whole.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_TRUE(first[i] == whole[i]) << recording << ": image " << i << " of " << frames;
    }
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

TEST(PrefixTest, RealRecordings) {
  SONDE_REQUIRE_DATA(ct, "ct-abdomen-totalseg/example_ct.nii.gz");
  SONDE_REQUIRE_DATA(sequences, "plus-sequences/sequences");
  const auto configs = test::data_dir() / "plus-sequences/config";
  const std::vector<std::pair<std::string, std::string>> recordings{
      {"SpinePhantomFreehand.igs.mha",
       "PlusDeviceSet_VolumeReconstructionOnly_SpinePhantom_NN_MEAN.xml"},
      {"BoneUltrasound_L14.igs.mha", "BoneUltrasound_L14_config.xml"},
      {"NwirePhantomFreehand.igs.mha",
       "PlusDeviceSet_NwirePhantomFreehand_vtkVolumeReconstructorTest2.xml"},
      {"fCal_Test_Calibration_3NWires.igs.mha", "PlusDeviceSet_fCal_Sim_VolumeReconstruction.xml"},
      {"USTC_3NWires_ProbeTranslation.igs.mha", "BoneUltrasound_L14_config.xml"}};
  for (const auto& [name, plus] : recordings) {
    SessionConfig config;
    if (name.starts_with("USTC")) config.source.tracker_frame = "StepperHome";
    config.ct.path = ct;
    config.source.plus_config = configs / plus;
    expect_prefixes(sequences / name, config, {4, 15});
  }
}

}  // namespace
}  // namespace nav::app
