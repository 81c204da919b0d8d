// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Replays on the command line.
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "app/report.hpp"
#include "io/sequence_writer.hpp"
#include "tests/app/options/command_line_support.hpp"

namespace nav::app {
namespace {

TEST_F(CommandLineTest, AReplayMeasuresDistancesFromItsNeedleAndItsTarget) {
  const std::string sweep = write_sweep({}, [](io::SequenceImage& frame) {
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    pose(0, 3) = 3.0 * static_cast<double>(frame.index);
    const auto status = frame.index < 4 ? TrackingStatus::kOk : TrackingStatus::kOccluded;
    io::set_transform(frame, {"NeedleTipToTracker", pose, status});
  });
  const std::string ct = write_ct();
  const auto set = [&](const std::string& kind) {
    const auto path = folder_ / (kind + ".json");
    std::ofstream(path) << R"({"sonde_predicates": 1, "name": "near", "predicates": [)"
                        << R"({"name": "near", "importance": 1, "hue_deg": 120, "saturation": 1,)"
                        << R"( "where": {")" << kind << R"(": {"low_mm": -1, "high_mm": 9}}}]})";
    return path.string();
  };
  const std::string base = replay_arguments(sweep) + " --us-volume " + ct + " --white 700";
  const std::string needle = base + " --predicates " + set("needle_distance");
  expect_rejection(needle, 2, {"needle_distance", "requires a needle", "--needle-frame"});
  const Outcome live = sonde(needle +
                             " --needle-frame NeedleTip --ct-from-reference "
                             "'1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1'");
  EXPECT_EQ(live.code, 0) << live.errors;
  EXPECT_EQ(read_json("replay.json")["frames"].size(), 7U) << "6 images and the animation";
  const std::string target = base + " --predicates " + set("target_distance");
  expect_rejection(target, 2, {"target_distance", "predicates.target_mm"});
  const auto session = folder_ / "target.toml";
  std::ofstream(session) << "[predicates]\ntarget_mm = [0.0, 0.0, 0.0, 10.0]\n";
  const Outcome aimed = sonde(target + " --session " + session.string());
  EXPECT_EQ(aimed.code, 0) << aimed.errors;
}

TEST_F(CommandLineTest, AReplayWarnsWhenOthersLowerTheMostImportantPredicate) {
  const auto set = folder_ / "set.json";
  std::ofstream(set) << R"({"sonde_predicates": 1, "name": "set", "predicates": [)"
                     << R"({"name": "bright", "importance": 0.8, "hue_deg": 120, "saturation": 1,)"
                     << R"( "where": {"intensity": {"low": 0.5}}},)"
                     << R"({"name": "tissue", "importance": 0.2, "hue_deg": 30, "saturation": 1,)"
                     << R"( "where": {"intensity": {"low": 0.1}}}]})";
  const std::string replay = replay_arguments(write_sweep()) + " --us-volume " + write_ct() +
                             " --white 700 --predicates " + set.string();
  const auto warning_of = [&](const std::string& options) {
    const Outcome outcome = sonde(replay + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    const auto at = outcome.errors.find("'bright', its most important predicate");
    return at == std::string::npos ? "" : outcome.errors.substr(at, 200);
  };
  EXPECT_NE(
      warning_of("").find("in 100 % of the voxels where it is true: there it counts for 0.53"),
      std::string::npos);
  EXPECT_NE(warning_of(" --predicate-importance bright=1").find("counts for 0.5 of"),
            std::string::npos);
  EXPECT_EQ(warning_of(" --no-cutaway"), "");
  const io::Json report = read_json("replay.json");
  EXPECT_NEAR(report["predicates"][0]["importance"].get<double>(), 0.8, 1e-12);
}

TEST_F(CommandLineTest, ReplaysASweepAndReportsThatItIsNotRegistered) {
  const Outcome outcome = sonde(replay_arguments(write_sweep()));
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const io::Json report = read_json("replay.json");
  EXPECT_EQ(report["ledger"]["received"], 6);
  EXPECT_EQ(report["ledger"]["shown"], 6);
  EXPECT_EQ(report["placement"]["kind"], "centred");
  EXPECT_NE(report["placement"]["statement"].get<std::string>().find("not registered"),
            std::string::npos);
  EXPECT_NE(report["reference"].get<std::string>().find("nothing tracks the patient"),
            std::string::npos);
  for (const char* file : {"report.json", "report.html", "pose_log.csv", "session.toml",
                           "replay_00000.png", "replay_00005.png", "replay.webp"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / file)) << file;
  }
}

TEST_F(CommandLineTest, AReplayWarnsOfASweepFarFromTheCt) {
  const std::string arguments = replay_arguments(write_sweep());
  const auto warnings = [&](const std::string& x_mm) {
    const Outcome outcome =
        sonde(arguments + " --ct-from-reference \"1 0 0 " + x_mm + " 0 1 0 0 0 0 1 0 0 0 0 1\"");
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    const io::Json report = read_json("replay.json");
    const bool said = outcome.errors.find("the sweep lies outside the CT") != std::string::npos;
    EXPECT_EQ(said, !report["placement"]["warnings"].empty()) << outcome.errors;
    return report["placement"]["warnings"].dump();
  };
  EXPECT_EQ(warnings("0"), "[]");
  // The CT ends at x = 58 mm.
  EXPECT_NE(warnings("5000").find("its nearest image is 49"), std::string::npos);
  EXPECT_NE(text_of(folder_ / "out/report.html").find("the sweep lies outside"), std::string::npos);
}

TEST_F(CommandLineTest, AReplayWarnsOfAPlanFarFromTheCt) {
  const std::string arguments = replay_arguments(write_sweep());
  const auto session = folder_ / "plan.toml";
  const auto said = [&](const std::string& entry, const std::string& target) {
    std::ofstream(session) << "[plan]\nentry_mm = " << entry << "\ntarget_mm = " << target
                           << "\ntarget_radius_mm = 6\n";
    const Outcome outcome = sonde(arguments + " --session " + session.string());
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return outcome.errors;
  };
  // The CT is 120 mm wide; the skin may lie slightly outside it.
  EXPECT_EQ(said("[0, -90, 0]", "[0, 0, 0]").find("plan."), std::string::npos);
  const std::string far_target = said("[0, -90, 0]", "[1500, 0, 0]");
  EXPECT_NE(far_target.find("plan.target_mm: it lies 1442 mm outside of the CT"), std::string::npos)
      << far_target;
  EXPECT_EQ(far_target.find("plan.entry_mm"), std::string::npos);
  const std::string far_entry = said("[0, -900, 0]", "[0, 0, 0]");
  EXPECT_NE(far_entry.find("plan.entry_mm: it lies 838 mm outside of the CT"), std::string::npos)
      << far_entry;
}

TEST_F(CommandLineTest, TextThatDoesNotFitStopsNoImage) {
  const Outcome outcome = sonde("replay " + write_sweep() + " --ct " + write_ct() + " --config " +
                                write_config() + " --out " + (folder_ / "out").string() +
                                " --frames 1 --step 4 --width 16 --height 1024");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
}

TEST_F(CommandLineTest, ReplayIsTheSameForOneAndTwoThreadsAndFromItsSessionFile) {
  const std::string sweep = write_sweep();
  const std::string arguments = replay_arguments(sweep);
  ASSERT_EQ(sonde(arguments + " --threads 1").code, 0);
  const io::Json one = read_json("replay.json");
  ASSERT_EQ(sonde(arguments + " --threads 2").code, 0);
  const io::Json two = read_json("replay.json");
  EXPECT_EQ(one["image_sha256"], two["image_sha256"]);
  EXPECT_EQ(one["pose_log_sha256"], two["pose_log_sha256"]);
  const Outcome again = sonde("replay --session " + (folder_ / "out/session.toml").string() +
                              " --json " + (folder_ / "again.json").string());
  ASSERT_EQ(again.code, 0) << again.errors;
  EXPECT_EQ(read_json("again.json")["image_sha256"], one["image_sha256"]);
}

TEST_F(CommandLineTest, AccountsForBadPosesAndTimes) {
  const std::string sweep = write_sweep({}, [](io::SequenceImage& frame) {
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    if (frame.index == 1) {
      pose(0, 0) = -1;  // A reflection.
      io::set_transform(frame, {"ProbeToTracker", pose, TrackingStatus::kOk});
    }
    if (frame.index == 2) frame.timestamp_s = 10.0;  // Backwards.
    if (frame.index == 3) {
      io::set_transform(frame, {"ProbeToTracker", pose, TrackingStatus::kOutOfVolume});
    }
  });
  expect_rejection(replay_arguments(sweep), 3,
                   {"sweep.igs.mha", "frame 1", "ProbeToTracker", "reflection", "2 of 6"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.json"));
  const Outcome outcome = sonde(replay_arguments(sweep) + " --skip-bad-frames");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const io::Json report = read_json("replay.json");
  EXPECT_EQ(report["ledger"]["received"], 6);
  EXPECT_EQ(report["ledger"]["shown"], 3);
  EXPECT_TRUE(report["ledger"]["balanced"]);
  EXPECT_EQ(report["ledger"]["rejected"]["Probe.not_tracked"], 2);
  EXPECT_EQ(report["rejected_poses"]["Probe.not_rigid"], 1);
  EXPECT_EQ(report["rejected_poses"]["Probe.status_not_ok"], 1);
}

TEST_F(CommandLineTest, AnImageWithAnInvalidCalibrationIsNotShown) {
  const auto sweep_with = [&](const Eigen::Matrix4d& second, TrackingStatus status) {
    return write_sweep({}, [&](io::SequenceImage& frame) {
      const Eigen::Matrix4d usual = Eigen::Matrix4d::Identity();
      const bool odd = frame.index == 2;
      io::set_transform(frame,
                        {"ImageToProbe", odd ? second : usual, odd ? status : TrackingStatus::kOk});
    });
  };
  const Eigen::Matrix4d none = Eigen::Matrix4d::Constant(std::nan(""));
  expect_rejection(replay_arguments(sweep_with(none, TrackingStatus::kOk)), 3,
                   {"sweep.igs.mha", "frame 2: ImageToProbe", "nan", "1 of 6"});
  const std::string skipping = " --skip-bad-frames";
  const auto expect_one_hidden = [&](const std::string& arguments) {
    const Outcome outcome = sonde(arguments);
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    EXPECT_NE(outcome.errors.find("frame 2: ImageToProbe"), std::string::npos) << outcome.errors;
    const io::Json report = read_json("replay.json");
    EXPECT_EQ(report["ledger"]["shown"], 5);
    EXPECT_EQ(report["ledger"]["rejected"]["unusable_picture"], 1);
  };
  expect_one_hidden(replay_arguments(sweep_with(none, TrackingStatus::kOk)) + skipping);
  expect_one_hidden(replay_arguments(sweep_with(none, TrackingStatus::kInvalid)));
  Eigen::Matrix4d moved = Eigen::Matrix4d::Identity();
  moved(0, 3) = 5;
  expect_rejection(replay_arguments(sweep_with(moved, TrackingStatus::kOk)), 3,
                   {"sweep.igs.mha", "frame 2: ImageToProbe", "frame 0", "5 mm away"});
  expect_one_hidden(replay_arguments(sweep_with(moved, TrackingStatus::kOk)) + skipping);
}

TEST_F(CommandLineTest, NamesTimesThatDoNotIncrease) {
  expect_rejection(replay_arguments(write_sweep({},
                                                [](io::SequenceImage& frame) {
                                                  if (frame.index == 4)
                                                    frame.timestamp_s = 10.3;  // That of frame 3.
                                                })),
                   3, {"frame 4", "Timestamp", "after 10.3", "found 10.3"});
}

TEST_F(CommandLineTest, SaysThatAMissingStatusDegrades) {
  const Outcome outcome = sonde(replay_arguments(write_sweep({}, [](io::SequenceImage& frame) {
    io::set_transform(frame,
                      {"ProbeToTracker", Eigen::Matrix4d::Identity(), TrackingStatus::kUnknown});
  })));
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("status of poses: none with some poses"), std::string::npos)
      << outcome.errors;
}

TEST_F(CommandLineTest, RejectsRecordingsWithoutAUsableImage) {
  const auto reject = [&](const std::string& sweep, std::initializer_list<std::string> pieces) {
    expect_rejection(replay_arguments(sweep), 3, pieces);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.json"));
  };
  reject(write_sweep([](auto& h) { h.image_type = "RGB_COLOR"; }), {"frame 0", "1 of RGB_COLOR"});
  reject(write_sweep([](auto& h) { h.pixel_type = io::PixelType::kFloat32; }),
         {"frame 0", "8 or 16 bits", "float32"});
  reject(write_sweep([](auto& h) { h.orientation = "XX"; }), {"UltrasoundImageOrientation", "XX"});
  reject(write_sweep({},
                     [](auto& f) {
                       io::set_transform(f,
                                         {"ProbeToTracker", Eigen::Matrix4d::Constant(std::nan("")),
                                          TrackingStatus::kInvalid});
                     }),
         {"Probe"});
  reject(write_sweep({}, [](auto& f) { f.timestamp_s.reset(); }), {"Timestamp"});
}

TEST_F(CommandLineTest, ImagesWaitForThePosesOfTheirOffset) {
  // Six images and poses, 100 ms apart.
  const std::string replay = replay_arguments(write_sweep());
  ASSERT_EQ(sonde(replay + " --temporal-offset-ms=-450").code, 0);
  EXPECT_EQ(read_json("replay.json")["ledger"]["rejected"]["Probe.no_pose_yet"], 5);
  ASSERT_EQ(sonde(replay + " --temporal-offset-ms=450").code, 0);
  EXPECT_EQ(read_json("replay.json")["ledger"]["rejected"]["Probe.before_first_pose"], 5);
  expect_rejection(replay + " --temporal-offset-ms=-2000", 3,
                   {"none of 6 frames usable: by --temporal-offset-ms -2000, 6 of 6 images lie "
                    "after the last pose, by 1500 to 2000 ms"});
  expect_rejection(replay + " --temporal-offset-ms=600", 3,
                   {"by --temporal-offset-ms 600, 6 of 6 images lie before the first pose, by 100 "
                    "to 600 ms"});
}

TEST_F(CommandLineTest, RejectsAnInvalidCalibration) {
  const std::string sweep = write_sweep();
  const std::string base = "replay " + sweep + " --ct " + write_ct() + " --out " +
                           (folder_ / "o").string() + " --config ";
  expect_rejection(base + write_config("nan 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), 3, {"plus.xml"});
  expect_rejection(base + write_config("0 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), 3, {});
  expect_rejection(base + write_config("1 2 3"), 3, {"16"});
}

TEST_F(CommandLineTest, RejectsRecordingsThatAreCutShort) {
  for (const bool compressed : {false, true}) {
    const std::string sweep = write_sweep([&](auto& h) { h.compressed = compressed; });
    ASSERT_EQ(sonde("info " + sweep).code, 0);
    std::filesystem::resize_file(sweep, std::filesystem::file_size(sweep) - 5);
    expect_rejection("info " + sweep, 3, {"sweep.igs.mha"});
    expect_rejection(replay_arguments(sweep), 3, {"sweep.igs.mha"});
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  }
}

TEST_F(CommandLineTest, ThePlacementOnTheCommandLineOverridesTheFile) {
  const std::string arguments = replay_arguments(write_sweep());
  const std::string matrix = "'1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1'";
  expect_rejection(arguments + " --registration r.json --ct-from-reference " + matrix, 2,
                   {"--ct-from-reference", "--registration"});
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[placement]\nregistration = \"missing.json\"\n";
  const std::string with_session = arguments + " --session " + session.string();
  expect_rejection(with_session, 3, {"missing.json"});
  const Outcome declared = sonde(with_session + " --ct-from-reference " + matrix);
  ASSERT_EQ(declared.code, 0) << declared.errors;
  EXPECT_EQ(read_json("replay.json")["placement"]["kind"], "declared");
  std::ofstream(session) << "[placement]\nregistration = \"missing.json\"\n"
                            "ct_from_reference_mm = [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]\n";
  expect_rejection(with_session, 3, {"placement.registration", "both"});
}

TEST_F(CommandLineTest, TimeStampsMayBeginBeforeTheOriginOfTheClock) {
  const auto played = [&](double shift_s) {
    const std::string sweep =
        write_sweep({}, [&](io::SequenceImage& frame) { *frame.timestamp_s += shift_s; });
    const Outcome outcome = sonde(replay_arguments(sweep));
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return read_json("replay.json");
  };
  const io::Json usual = played(0);
  const io::Json early = played(-1000);
  EXPECT_EQ(early["ledger"], usual["ledger"]);
  EXPECT_EQ(early["image_sha256"], usual["image_sha256"]);
}

/// TOML is UTF-8, but file names may have other bytes: the session would name another file.
TEST_F(CommandLineTest, ASessionNeverNamesAnotherFileThanTheGivenOne) {
  const std::string latin = "c\xe9t.mha";
  const std::string latin_shown = "c\\xe9t.mha";  // Messages are UTF-8.
  for (const char* verb : {"replay s.mha --ct ", "slices ", "predicates "}) {
    expect_rejection(verb + latin + " --print-session", 2, {"UTF-8", latin_shown});
  }
  const std::string sweep = write_sweep();
  std::filesystem::create_directory(folder_ / "out");
  std::ofstream(folder_ / "out/report.html") << "earlier";
  const std::string appearance = (folder_ / "\xff.json").string();
  expect_rejection(replay_arguments(sweep) + " --save-appearance " + appearance, 2,
                   {"--save-appearance", "UTF-8", "\\xff.json"});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/report.html"));
  EXPECT_EQ(sonde("replay c\xc3\xa9t.mha --print-session").code, 0);
}

TEST_F(CommandLineTest, MoreThreadsThanCoresCauseNoMessages) {
  const Outcome outcome = sonde(replay_arguments(write_sweep()) + " --threads 1000");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors.find("TBB"), std::string::npos) << outcome.errors;
}

}  // namespace
}  // namespace nav::app
