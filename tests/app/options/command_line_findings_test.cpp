// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Every verb names contradictions in the same words, and files that go away stop a run.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <thread>

#include "tests/app/options/command_line_support.hpp"

namespace nav::app {
namespace {

constexpr int kFrames = 30;

class FindingsTest : public CommandLineTest {
 protected:
  /// A sweep of changing images with a calibration in its frames; \p change adds the fault.
  std::string write_faulty(const std::function<void(io::SequenceImage&)>& change) {
    return write_sweep(
        {},
        [&](io::SequenceImage& frame) {
          for (std::size_t i = 0; i < frame.pixels.size(); ++i) {
            frame.pixels[i] = static_cast<std::byte>(i + 7 * static_cast<std::size_t>(frame.index));
          }
          Eigen::Matrix4d image_to_probe = Eigen::Matrix4d::Identity();
          image_to_probe.diagonal() << 0.5, 0.5, 0.5, 1;
          image_to_probe(0, 3) = -8;
          io::set_transform(frame, {"ImageToProbe", image_to_probe, TrackingStatus::kOk});
          change(frame);
        },
        kFrames);
  }
  std::string replay_of(const std::string& sweep, const std::string& options = "") {
    return "replay " + sweep + " --ct " + write_ct() + " --out " + (folder_ / "out").string() +
           " --width 96 --height 64 --step 2 --frames 3 --skip-bad-frames --json " +
           (folder_ / "replay.json").string() + " " + options;
  }
  /// The finding of a report with that key; null if there is none.
  static io::Json with_key(const io::Json& report, const std::string& key) {
    for (const io::Json& finding : report.at("findings")) {
      if (finding.at("key") == key) return finding;
    }
    return nullptr;
  }
  /// Expects info and replay to say the same about a sweep: a finding whose values contain a text.
  void expect_both_say(const std::string& sweep, const std::string& key, const std::string& text,
                       const std::string& options = "") {
    const Outcome info = sonde("info " + sweep + " --json " + (folder_ / "info.json").string());
    ASSERT_EQ(info.code, 0) << info.errors;
    const Outcome replay = sonde(replay_of(sweep, options));
    ASSERT_EQ(replay.code, 0) << replay.errors;
    const io::Json by_info = with_key(read_json("info.json"), key);
    const io::Json by_replay = with_key(read_json("replay.json"), key);
    ASSERT_FALSE(by_info.is_null()) << key << "\n" << info.errors;
    ASSERT_FALSE(by_replay.is_null()) << key << "\n" << replay.errors;
    EXPECT_EQ(by_info["values"], by_replay["values"]);
    EXPECT_EQ(by_info["used"], by_replay["used"]);
    EXPECT_NE(by_info["values"].dump().find(text), std::string::npos) << by_info;
    const std::string sentence = key + ": ";
    EXPECT_NE(info.errors.find(sentence), std::string::npos) << info.errors;
    EXPECT_NE(replay.errors.find(sentence), std::string::npos) << replay.errors;
  }
};

TEST_F(FindingsTest, AWellFormedSweepHasNoFindings) {
  const std::string sweep = write_faulty([](io::SequenceImage&) {});
  ASSERT_EQ(sonde("info " + sweep + " --json " + (folder_ / "info.json").string()).code, 0);
  EXPECT_EQ(read_json("info.json")["findings"], io::Json::array());
}

TEST_F(FindingsTest, InfoSaysWhatAReplaySaysOfCalibrations) {
  expect_both_say(write_faulty([](io::SequenceImage& frame) {
                    io::set_transform(
                        frame, {"ImageToProbe", Eigen::Matrix4d::Identity(), TrackingStatus::kOk});
                  }),
                  "ImageToProbe", "the identity");
  expect_both_say(write_faulty([](io::SequenceImage& frame) {
                    Eigen::Matrix4d metres = Eigen::Matrix4d::Identity();
                    metres.diagonal() << 5e-4, 5e-4, 5e-4, 1;
                    io::set_transform(frame, {"ImageToProbe", metres, TrackingStatus::kOk});
                  }),
                  "ImageToProbe", "in metres?");
}

TEST_F(FindingsTest, InfoSaysWhatAReplaySaysOfTimesAndPoses) {
  expect_both_say(write_faulty([](io::SequenceImage& frame) { *frame.timestamp_s *= 1e3; }),
                  "Timestamp", "milliseconds?");
  expect_both_say(write_faulty([](io::SequenceImage& frame) {
                    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
                    pose(2, 3) = 2.0 * static_cast<double>(std::min<std::int64_t>(frame.index, 7));
                    io::set_transform(frame, {"ProbeToTracker", pose, TrackingStatus::kOk});
                  }),
                  "pose", "unchanged to the last digit");
  expect_both_say(write_faulty([](io::SequenceImage& frame) {
                    const Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
                    io::set_transform(frame, {"ReferenceToTracker", pose, TrackingStatus::kOk});
                    Eigen::Matrix4d away = pose;
                    away(0, 3) = 20;
                    io::set_transform(frame, {"ProbeToReference", away, TrackingStatus::kOk});
                  }),
                  "position of Probe in Reference", "ProbeToReference");
}

TEST_F(FindingsTest, InfoSaysWhatAReplaySaysOfImagesAndLengths) {
  expect_both_say(write_faulty([](io::SequenceImage& frame) {
                    if (frame.index < 7) return;
                    for (std::size_t i = 0; i < frame.pixels.size(); ++i) {
                      frame.pixels[i] = static_cast<std::byte>(i);
                    }
                  }),
                  "pixels", "the scanner is frozen or repeats images");
  const std::string longer = write_faulty([](io::SequenceImage&) {});
  std::ofstream(longer, std::ios::app | std::ios::binary) << "tail";
  const std::string stated = std::to_string(32 * 24 * kFrames);
  expect_both_say(longer, "length of the samples", stated + " bytes stated");
}

TEST_F(FindingsTest, ACutRecordingIsNamedWithoutASurvey) {
  const std::string sweep = write_faulty([](io::SequenceImage&) {});
  std::filesystem::resize_file(sweep, std::filesystem::file_size(sweep) - 32 * 24 * 10 - 1);
  const Outcome surveyed = sonde(replay_of(sweep));
  EXPECT_EQ(surveyed.code, 3) << surveyed.errors;
  const Outcome replay = sonde(replay_of(sweep, "--no-survey"));
  ASSERT_EQ(replay.code, 0) << replay.errors;
  const io::Json report = read_json("replay.json");
  const io::Json length = with_key(report, "length of the samples");
  ASSERT_FALSE(length.is_null()) << report["findings"];
  EXPECT_EQ(length["values"],
            io::Json({std::to_string(kFrames) + " frames stated", "19 with all their pixels"}));
}

TEST_F(FindingsTest, BadFramesAreNamedWithoutASurvey) {
  const std::string sweep = write_faulty([](io::SequenceImage& frame) {
    if (frame.index != 4) return;
    Eigen::Matrix4d bent = Eigen::Matrix4d::Identity();
    bent(0, 0) = 2;
    io::set_transform(frame, {"ProbeToTracker", bent, TrackingStatus::kOk});
  });
  std::string all = replay_of(sweep, "--no-survey");
  all.replace(all.find(" --frames 3"), 11, "");
  const Outcome replay = sonde(all);
  ASSERT_EQ(replay.code, 0) << replay.errors;
  const io::Json bad = with_key(read_json("replay.json"), "frames");
  ASSERT_FALSE(bad.is_null());
  EXPECT_NE(bad["values"].dump().find("1 of 30 that are bad, the first: frame 4"),
            std::string::npos)
      << bad;
}

TEST_F(FindingsTest, VolumesThatAreNoCtAreCalledSo) {
  VoxelGrid grid;
  grid.size = {8, 8, 8};
  grid.spacing_mm = {2, 2, 2};
  for (const bool ct : {true, false}) {
    std::vector<std::int16_t> values(grid.voxel_count(), ct ? -900 : 200);
    values[3] = 700;
    const auto path = (folder_ / "volume.mha").string();
    ASSERT_TRUE(test::has_value(
        io::write_ct_mha(*StoredVolume::create(grid, std::move(values), "v"), path)));
    ASSERT_EQ(sonde("info " + path + " --json " + (folder_ / "info.json").string()).code, 0);
    const io::Json info = read_json("info.json");
    EXPECT_EQ(info["kind"], ct ? "ct" : "volume");
    EXPECT_EQ(info["hu_max"], ct ? io::Json(700) : io::Json());
    EXPECT_EQ(info["value_max"], 700);
  }
}

TEST_F(FindingsTest, APartOfACtWithLittleAirIsACt) {
  VoxelGrid grid;
  grid.size = {8, 8, 8};
  grid.spacing_mm = {2, 2, 2};
  std::vector<std::int16_t> values(grid.voxel_count(), 40);
  values[3] = 900;
  values[4] = -500;
  const auto path = (folder_ / "part.mha").string();
  ASSERT_TRUE(
      test::has_value(io::write_ct_mha(*StoredVolume::create(grid, std::move(values), "v"), path)));
  const Outcome outcome = sonde("info " + path);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  for (const char* line : {"kind: \"ct\"\n", "hu_min: -500\n", "hu_max: 900\n"}) {
    EXPECT_NE(outcome.output.find(line), std::string::npos) << line << outcome.output;
  }
}

TEST_F(FindingsTest, InfoJudgesPlusConfigurations) {
  const std::string config = write_config();  // Its ImageToProbe is the identity.
  const Outcome info = sonde("info " + config + " --json " + (folder_ / "info.json").string());
  ASSERT_EQ(info.code, 0) << info.errors;
  const io::Json finding = with_key(read_json("info.json"), "ImageToProbe");
  ASSERT_FALSE(finding.is_null());
  EXPECT_EQ(finding["subject"], config);
  EXPECT_NE(info.errors.find("the identity (is the probe calibrated?)"), std::string::npos);
}

TEST_F(FindingsTest, InfoSaysWhatAReplaySaysOfANeedleThatPointsBackwards) {
  expect_both_say(write_faulty([](io::SequenceImage& frame) {
                    Eigen::Matrix4d hub = Eigen::Matrix4d::Identity();
                    hub(0, 3) = static_cast<double>(frame.index);
                    io::set_transform(frame, {"NeedleToTracker", hub, TrackingStatus::kOk});
                    Eigen::Matrix4d tip = Eigen::Matrix4d::Identity();
                    tip.diagonal() << 1, -1, -1, 1;
                    tip(2, 3) = 150;
                    io::set_transform(frame, {"NeedleTipToNeedle", tip, TrackingStatus::kOk});
                  }),
                  "direction of NeedleTip", "150 mm ahead of the tip", "--needle-frame NeedleTip");
}

TEST_F(FindingsTest, ARegistrationWithoutAFrameIsNamedByInfoAndReplay) {
  const auto points = folder_ / "points.csv";
  std::ofstream(points) << "a,0,0,0,0,0,0\nb,40,0,0,40,0,0\nc,0,40,0,0,40,0\nd,0,0,40,0,0,40\n";
  const std::string ct = write_ct();
  const std::string file = (folder_ / "registration.json").string();
  const Outcome made =
      sonde("register --landmarks " + points.string() + " --ct " + ct + " --json " + file);
  ASSERT_EQ(made.code, 0) << made.errors;
  EXPECT_EQ(read_json("registration.json")["findings"], io::Json::array());
  const Outcome info = sonde("info " + file + " --json " + (folder_ / "info.json").string());
  ASSERT_EQ(info.code, 0) << info.errors;
  const io::Json described = read_json("info.json");
  EXPECT_EQ(described["kind"], "registration");
  EXPECT_EQ(described["method"], "landmarks");
  const Outcome replay =
      sonde(replay_of(write_faulty([](io::SequenceImage&) {}), "--registration " + file));
  ASSERT_EQ(replay.code, 0) << replay.errors;
  const io::Json by_info = with_key(described, "reference_frame");
  const io::Json by_replay = with_key(read_json("replay.json"), "reference_frame");
  ASSERT_FALSE(by_info.is_null()) << info.errors;
  EXPECT_EQ(by_info["subject"], file);
  EXPECT_EQ(by_info, by_replay);
}

TEST_F(FindingsTest, EveryVerbSaysThatACtIsNotInHounsfieldUnits) {
  VoxelGrid grid;
  grid.size = {24, 24, 24};
  grid.spacing_mm = {4, 4, 4};
  grid.origin_mm = {-48, -48, -48};
  const auto path = (folder_ / "other.mha").string();
  const auto points = folder_ / "points.csv";
  std::ofstream(points) << "a,0,0,0,0,0,0\nb,40,0,0,40,0,0\nc,0,40,0,0,40,0\nd,0,0,40,0,0,40\n";
  for (const auto& [most, guess] : {std::pair(2024, "HU + 1024?"), {255, "in 8 bits?"}}) {
    std::vector<std::int16_t> values(grid.voxel_count());
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = static_cast<std::int16_t>(i % static_cast<std::size_t>(most + 1));
    }
    ASSERT_TRUE(test::has_value(
        io::write_ct_mha(*StoredVolume::create(grid, std::move(values), "ct"), path)));
    const std::string sweep = write_faulty([](io::SequenceImage&) {});
    const std::string sentence = path + ": unit of the values: 0 to " + std::to_string(most) +
                                 ", none below -200 HU, air (is it ";
    for (const std::string& command :
         {"info " + path, "slices " + path + " --out " + (folder_ / "s").string(),
          "register --landmarks " + points.string() + " --ct " + path + " --json " +
              (folder_ / "r.json").string(),
          "replay " + sweep + " --ct " + path + " --out " + (folder_ / "out").string() +
              " --width 96 --height 64 --step 2 --frames 2"}) {
      const Outcome outcome = sonde(command);
      EXPECT_EQ(outcome.code, 0) << command << "\n" << outcome.errors;
      EXPECT_NE(outcome.errors.find(sentence), std::string::npos) << command << outcome.errors;
      EXPECT_NE(outcome.errors.find(guess), std::string::npos) << command << outcome.errors;
    }
    EXPECT_FALSE(with_key(read_json("r.json"), "unit of the values").is_null());
  }
  const Outcome as_mr =
      sonde("replay " + write_faulty([](io::SequenceImage&) {}) + " --ct " + path + " --out " +
            (folder_ / "out").string() +
            " --width 96 --height 64 --step 2 --frames 2 --transfer-function mr-default");
  EXPECT_EQ(as_mr.code, 0) << as_mr.errors;
  EXPECT_EQ(as_mr.errors.find("unit of the values"), std::string::npos) << as_mr.errors;
}

TEST_F(FindingsTest, AFileCutWhileItIsReplayedEndsTheRunWithTheCauseAndWhatIsComplete) {
  constexpr int kMany = 1200;
  const std::string sweep = write_sweep({}, {}, kMany);
  const auto first = folder_ / "out" / "replay_00002.png";
  const pid_t cutter = ::fork();
  ASSERT_GE(cutter, 0);
  if (cutter == 0) {
    for (int i = 0; i < 60000 && !std::filesystem::exists(first); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::error_code failed;
    const auto size = std::filesystem::file_size(sweep, failed);
    std::filesystem::resize_file(sweep, size - 32 * 24 * kMany / 2, failed);
    ::_exit(failed ? 1 : 0);
  }
  const std::string arguments = replay_arguments(sweep);
  const Outcome outcome = sonde(arguments);
  int status = 0;
  ASSERT_EQ(::waitpid(cutter, &status, 0), cutter);
  ASSERT_EQ(exit_code_of(status), 0);
  expect_rejection(outcome, arguments, 3,
                   {"sweep.igs.mha", "became shorter while it was read", "complete in",
                    "out: ", " images; the report was not written"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "report.json"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "report.html"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "replay.json"));
  // The folder has the images that the message counts, all complete.
  std::size_t images = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder_ / "out")) {
    const std::string name = file.path().filename().string();
    if (name.starts_with("replay_")) ++images;
    EXPECT_TRUE(name.ends_with(".png") || name.starts_with(".")) << name;
  }
  EXPECT_NE(outcome.errors.find(": " + std::to_string(images) + " images; the report"),
            std::string::npos)
      << images << outcome.errors;
}

}  // namespace
}  // namespace nav::app
