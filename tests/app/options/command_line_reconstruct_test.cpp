// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/options/command_line_support.hpp"

namespace nav::app {
namespace {

class ReconstructCommandTest : public CommandLineTest {
 protected:
  /// Images of 32 x 24 pixels of 1 mm, 2 mm apart, of values 40, 70, 100, …
  std::string arguments(const std::string& more = "") { return arguments_for(write_sweep(), more); }
  std::string arguments_for(const std::string& sweep, const std::string& more) {
    return "reconstruct " + sweep + " --config " + write_config() + " --out " + volume() +
           " --json " + (folder_ / "report.json").string() + " " + more;
  }
  std::string volume() { return (folder_ / "us.mha").string(); }
  StoredVolume read_volume(const std::string& name = "us.mha") {
    CollectingDiagnostics diagnostics;
    return *io::read_stored_volume(folder_ / name, diagnostics);
  }
};

TEST_F(ReconstructCommandTest, WritesTheVolumeAndItsReport) {
  const Outcome outcome = sonde(arguments("--spacing-mm 1"));
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("32 x 24 x 11 voxels of 1 mm"), std::string::npos)
      << outcome.errors;
  const StoredVolume written = read_volume();
  for (int k = 0; k < 11; ++k) {
    EXPECT_EQ(written.at(5, 7, k), k % 2 == 0 ? 40 + 15 * k : -1) << k;
  }
  const io::Json report = read_json("report.json");
  EXPECT_EQ(report["verb"], "reconstruct");
  EXPECT_EQ(report["frames"]["used"], 6);
  EXPECT_TRUE(report["frames"]["rejected"].empty());
  EXPECT_EQ(report["voxels"]["seen"], 32 * 24 * 6);
  EXPECT_EQ(report["voxels"]["filled"], 0);
  EXPECT_EQ(report["voxels"]["empty"], 32 * 24 * 5);
  EXPECT_EQ(report["spacing_mm"], 1.0);
  EXPECT_GT(report["bytes"], 32 * 24 * 11);
  EXPECT_GE(report["fps_p50"], report["fps_p95"]);
  EXPECT_GT(report["seconds"], 0.0);
  EXPECT_EQ(report["sha256"].get<std::string>().size(), 64U);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "us.scan-lines.mha"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "us.origin.mha"));
}

TEST_F(ReconstructCommandTest, FillsHolesAndMarksThemWhenAsked) {
  ASSERT_EQ(sonde(arguments("--spacing-mm 1 --fill 1")).code, 0);
  const StoredVolume written = read_volume();
  const StoredVolume origins = read_volume("us.origin.mha");
  for (int k = 0; k < 11; ++k) {
    EXPECT_EQ(written.at(5, 7, k), 40 + 15 * k);
    EXPECT_EQ(origins.at(5, 7, k), k % 2 == 0 ? 1 : 2);
  }
  EXPECT_EQ(read_json("report.json")["voxels"]["filled"], 32 * 24 * 5);
}

TEST_F(ReconstructCommandTest, OtherVerbsReadTheVolumeAndItsScanLines) {
  ASSERT_EQ(sonde(arguments("--spacing-mm 1 --method backward --reach-mm 2")).code, 0);
  Outcome outcome = sonde("info " + volume());
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("dimensions: [32,24,11]"), std::string::npos) << outcome.output;
  EXPECT_EQ(sonde("slices " + volume() + " --size 64 --out " + (folder_ / "slices").string()).code,
            0);
  // Both need scan lines, and no option gives them.
  outcome =
      sonde("derive " + volume() + " --feature depth --out " + (folder_ / "features").string());
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  std::istringstream row(outcome.output.substr(outcome.output.find("depth ")));
  std::string name, unit;
  double least = -1, low = 0, high = 0, greatest = 0;
  row >> name >> unit >> least >> low >> high >> greatest;
  EXPECT_EQ(least, 0) << outcome.output;  // From the first row of the images to the last.
  EXPECT_EQ(greatest, 23) << outcome.output;
  const std::string draw = "predicates " + volume() +
                           " --predicates shoulder-bone --width 200 --height 200 --out " +
                           (folder_ / "both.png").string();
  EXPECT_EQ(sonde(draw).code, 0);
  // Scan lines of other voxels are not used.
  ASSERT_EQ(sonde(arguments("--spacing-mm 1 --compound max")).code, 0);
  expect_rejection(draw, 2, {"requires scan-line directions"});
  EXPECT_NE(sonde(draw).errors.find("belongs to other voxels"), std::string::npos);
}

TEST_F(ReconstructCommandTest, TakesClipAndFanOfTheConfigurationAndOfOptions) {
  const auto config = folder_ / "clip.xml";
  std::ofstream(config)
      << "<PlusConfiguration version=\"2.3\"><CoordinateDefinitions><Transform From=\"Image\" "
         "To=\"Probe\" Matrix=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\"/></CoordinateDefinitions>"
         "<VolumeReconstruction OutputSpacing=\"2 2 2\" ClipRectangleOrigin=\"4 2\" "
         "ClipRectangleSize=\"10 8\"/></PlusConfiguration>";
  const std::string command = "reconstruct " + write_sweep() + " --config " + config.string() +
                              " --out " + volume() + " --json " +
                              (folder_ / "report.json").string();
  ASSERT_EQ(sonde(command).code, 0);
  EXPECT_EQ(read_json("report.json")["size"], io::Json({6, 5, 6}));
  EXPECT_EQ(read_json("report.json")["spacing_mm"], 2.0);
  ASSERT_EQ(sonde(command + " --spacing-mm 1 --clip 0 0 5 5").code, 0);
  EXPECT_EQ(read_json("report.json")["size"], io::Json({6, 6, 11}));
  ASSERT_EQ(sonde(command + " --spacing-mm 1 --clip 0 0 31 23 --fan -45 45 16 0 5 10").code, 0);
  const io::Json report = read_json("report.json");
  EXPECT_EQ(report["size"], io::Json({32, 24, 11}));
  // A quarter of a ring of radii 5 and 10.
  EXPECT_NEAR(report["voxels"]["seen"].get<double>() / 6, M_PI / 4 * (100 - 25), 8);
}

TEST_F(ReconstructCommandTest, CountsImagesWithoutPoseByCause) {
  int n = 0;
  const std::string sweep = write_sweep({}, [&](io::SequenceImage& frame) {
    if (n++ % 3 != 1) return;
    const Eigen::Matrix4d none = Eigen::Matrix4d::Identity();
    io::set_transform(frame, {"ProbeToTracker", none, TrackingStatus::kInvalid});
  });
  const Outcome outcome = sonde(arguments_for(sweep, "--spacing-mm 1"));
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const io::Json frames = read_json("report.json")["frames"];
  std::uint64_t rejected = 0;
  for (const auto& [cause, count] : frames["rejected"].items()) {
    EXPECT_NE(cause.find("Probe"), std::string::npos) << cause;
    rejected += count.get<std::uint64_t>();
  }
  EXPECT_EQ(frames["used"].get<std::uint64_t>() + rejected, 6U);
  EXPECT_GT(rejected, 0U);
}

TEST_F(ReconstructCommandTest, WarnsOfASweepThatNeverMoves) {
  const std::string sweep = write_sweep({}, [](io::SequenceImage& frame) {
    io::set_transform(frame, {"ProbeToTracker", Eigen::Matrix4d::Identity(), TrackingStatus::kOk});
  });
  const Outcome outcome = sonde(arguments_for(sweep, "--spacing-mm 1"));
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("move by at most 0 mm, less than a voxel (1 mm)"),
            std::string::npos)
      << outcome.errors;
}

TEST_F(ReconstructCommandTest, RejectsBadInput) {
  expect_rejection(arguments("--spacing-mm 0"), 2, {"--spacing-mm", "0.0001 to 1000 mm", "0"});
  expect_rejection(arguments("--spacing-mm nan"), 2, {"--spacing-mm", "nan"});
  // Nearly 10^12 voxels.
  expect_rejection(arguments("--spacing-mm 0.002"), 2,
                   {"--spacing-mm", "2^31 voxels", "15501 x 11501 x 5001", "mm has room"});
  expect_rejection(arguments("--spacing-mm 0.02"), 2, {"memory", "GB", "--spacing-mm"});
  expect_rejection(arguments("--clip 0 0 0 5"), 2, {"clip rectangle", "size > 0"});
  expect_rejection(arguments("--clip 40 0 5 5"), 2, {"--clip", "no pixel"});
  expect_rejection(arguments("--fan 5 5 16 0 1 2"), 2, {"fan", "increasing"});
  expect_rejection(arguments("--reach-mm 2"), 2, {"--reach-mm requires --method backward"});
  expect_rejection(arguments("--method cubic"), 2, {"--method", "nearest", "cubic"});
  expect_rejection("reconstruct " + write_sweep() + " --config " + write_config() + " --out " +
                       (folder_ / "us.nrrd").string(),
                   2, {"--out", ".mha"});
  expect_rejection("reconstruct " + write_sweep() + " --out " + volume(), 3, {"Image", "Probe"});
  expect_rejection(
      "reconstruct " + write_sweep() + " --config " + write_config() + " --out " + write_sweep(), 2,
      {"--out", "sweep"});
  EXPECT_FALSE(std::filesystem::exists(volume()));
}

TEST_F(ReconstructCommandTest, RejectsTwoCalibrationsInOneSweep) {
  int n = 0;
  const std::string sweep = write_sweep({}, [&](io::SequenceImage& frame) {
    Eigen::Matrix4d calibration = Eigen::Matrix4d::Identity();
    if (n++ == 3) calibration(0, 3) = 5;
    io::set_transform(frame, {"ImageToProbe", calibration, TrackingStatus::kOk});
  });
  const std::string command = "reconstruct " + sweep + " --out " + volume();
  expect_rejection(command, 3, {"calibration", "--skip-bad-frames"});
  const Outcome outcome = sonde(command + " --spacing-mm 1 --skip-bad-frames --json " +
                                (folder_ / "report.json").string());
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(read_json("report.json")["frames"]["used"], 5);
}

}  // namespace
}  // namespace nav::app
