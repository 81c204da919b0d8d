// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/camera/marker_finder.hpp"

#include <gtest/gtest.h>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "devices/camera/cv_camera_model.hpp"
#include "devices/camera/cv_marker_corners.hpp"
#include "devices/camera/cv_planar_pose.hpp"
#include "tests/devices/marker_renderer.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// Markers in images of a renderer of its own, and in real ones.
namespace nav::devices {
namespace {

using test::pattern_pose;

constexpr double kDeg = std::numbers::pi / 180;
constexpr int kDictionary4x4 = 0;

struct FinderBench {
  explicit FinderBench(std::vector<MarkerTool> wanted) : tools(std::move(wanted)) {}

  std::unique_ptr<MarkerFinder> finder() {
    const auto file = (folder / "camera.yml");
    camera.write(file.string());
    auto made = make_marker_finder({.tools = tools, .camera = file});
    EXPECT_TRUE(test::has_value(made));
    return *std::move(made);
  }
  std::vector<MarkerReading> find(const std::vector<Eigen::Matrix4d>& poses, unsigned seed = 1) {
    test::MarkerRenderer renderer(camera, kDictionary4x4, seed);
    for (std::size_t i = 0; i < poses.size(); ++i) renderer.add(tools[i], poses[i]);
    auto found = finder()->find(renderer.image());
    EXPECT_TRUE(test::has_value(found));
    return *std::move(found);
  }
  test::TemporaryFolder folder;
  test::TestCamera camera;
  std::vector<MarkerTool> tools;
};

/// Distance of a pose from where it should be.
double off_mm(const MarkerReading& reading, const Eigen::Matrix4d& truth) {
  return (reading.camera_from_tool - truth).topRightCorner<3, 1>().norm();
}

struct Errors {
  double rms_mm = 0, rms_deg = 0, mean_depth_mm = 0, mean_claimed_mm = 0;
  int found = 0, ambiguous = 0;
};

/// Errors over poses with tilts of 20 to 50 degrees.
Errors errors_of(FinderBench& bench, double distance_mm, int poses = 12) {
  Errors errors;
  for (int i = 0; i < poses; ++i) {
    const Eigen::Matrix4d truth = pattern_pose(
        distance_mm, (20 + 30.0 * i / (poses - 1)) * kDeg, 77.0 * i * kDeg, 31.0 * i * kDeg,
        0.03 * distance_mm * (i % 5 - 2), 0.025 * distance_mm * (i % 4 - 1.5));
    const auto found = bench.find({truth}, static_cast<unsigned>(i + 1)).front();
    EXPECT_GT(found.points, 0) << "pose " << i;
    if (found.points == 0) continue;
    ++errors.found;
    errors.ambiguous += found.ambiguous ? 1 : 0;
    const Eigen::Vector3d off = (found.camera_from_tool - truth).topRightCorner<3, 1>();
    const Eigen::Matrix3d turn =
        found.camera_from_tool.topLeftCorner<3, 3>() * truth.topLeftCorner<3, 3>().transpose();
    const double angle = Eigen::AngleAxisd(turn).angle() / kDeg;
    errors.rms_mm += off.squaredNorm() / poses;
    errors.rms_deg += angle * angle / poses;
    errors.mean_depth_mm += off.z() / poses;
    errors.mean_claimed_mm += found.error_mm / poses;
  }
  errors.rms_mm = std::sqrt(errors.rms_mm);
  errors.rms_deg = std::sqrt(errors.rms_deg);
  ::testing::Test::RecordProperty("rms_um", static_cast<int>(1000 * errors.rms_mm));
  // For docs/figures.md.
  std::cout << bench.tools.front().columns << " x " << bench.tools.front().rows << " at "
            << distance_mm << " mm: " << errors.rms_mm << " mm, " << errors.rms_deg
            << " degrees, depth " << errors.mean_depth_mm << " mm, claimed "
            << errors.mean_claimed_mm << " mm\n";
  return errors;
}

TEST(MarkerFinderTest, AMarkerOf40MmIsFoundToThreeTenthsOfAMillimetreAt600Mm) {
  FinderBench bench({*marker_tool("marker:7:40")});
  const Errors errors = errors_of(bench, 600);
  EXPECT_EQ(errors.found, 12);
  EXPECT_EQ(errors.ambiguous, 0);
  EXPECT_LE(errors.rms_mm, 0.3) << "depth " << errors.mean_depth_mm;
  EXPECT_LE(errors.rms_deg, 0.5);
  // Its own figure of its error is about right.
  EXPECT_GT(errors.mean_claimed_mm, 0.3 * errors.rms_mm);
  EXPECT_LT(errors.mean_claimed_mm, 10 * errors.rms_mm);
}

TEST(MarkerFinderTest, ACharucoBoardIsFoundToATwentiethOfAMillimetreAt600Mm) {
  FinderBench bench({*marker_tool("charuco:5x7:20:15")});
  const Errors errors = errors_of(bench, 600);
  EXPECT_EQ(errors.found, 12);
  EXPECT_EQ(errors.ambiguous, 0);
  EXPECT_LE(errors.rms_mm, 0.05) << "depth " << errors.mean_depth_mm;
  EXPECT_LE(errors.rms_deg, 0.05);
}

TEST(MarkerFinderTest, ALensThatBendsLinesCostsNothing) {
  FinderBench bench({*marker_tool("charuco:5x7:20:15")});
  bench.camera.k1 = -0.25;
  bench.camera.k2 = 0.08;
  const Errors errors = errors_of(bench, 600, 3);
  EXPECT_EQ(errors.found, 3);
  EXPECT_LE(errors.rms_mm, 0.08) << "depth " << errors.mean_depth_mm;
}

TEST(MarkerFinderTest, AGridUsesAllMarkersThatItSees) {
  FinderBench bench({*marker_tool("grid:3x2:20:6:10")});
  const Eigen::Matrix4d truth = pattern_pose(600, 30 * kDeg, 1);
  const auto whole = bench.find({truth}).front();
  EXPECT_EQ(whole.markers, 6);
  EXPECT_EQ(whole.points, 24);
  EXPECT_LT(off_mm(whole, truth), 0.5);
  // Half of it lies outside the image.
  const Eigen::Matrix4d beside = pattern_pose(600, 30 * kDeg, 1, 0, 270, 0);
  const auto part = bench.find({beside}).front();
  EXPECT_GT(part.markers, 0);
  EXPECT_LT(part.markers, 6);
  EXPECT_LT(off_mm(part, beside), 1.5);
}

TEST(MarkerFinderTest, SeveralToolsAreToldApartAndAHiddenOneHasNoPose) {
  FinderBench bench(
      {*marker_tool("marker:7:40"), *marker_tool("marker:8:40"), *marker_tool("marker:9:40")});
  const Eigen::Matrix4d left = pattern_pose(600, 30 * kDeg, 0.3, 0.5, -80, 0);
  const Eigen::Matrix4d right = pattern_pose(700, 35 * kDeg, 2.0, 2.5, 90, 20);
  const auto found = bench.find({left, right});
  ASSERT_EQ(found.size(), 3U);
  EXPECT_LT(off_mm(found[0], left), 1);
  EXPECT_LT(off_mm(found[1], right), 1.5);
  EXPECT_EQ(found[2].markers, 0);
  EXPECT_EQ(found[2].points, 0);
  EXPECT_FALSE(found[2].camera_from_tool.allFinite());
}

/// Seen from the front, a small marker may be tilted either way; tilted, it may not.
TEST(MarkerFinderTest, AnAmbiguousPoseIsSaid) {
  FinderBench bench({*marker_tool("marker:7:20")});
  int frontal = 0, tilted = 0;
  for (int i = 0; i < 6; ++i) {
    const auto seed = static_cast<unsigned>(i + 1);
    const auto front = bench.find({pattern_pose(900, 10 * kDeg, i, 0, 0, 0)}, seed).front();
    ASSERT_GT(front.points, 0);
    frontal += front.ambiguous ? 1 : 0;
    const auto slant = bench.find({pattern_pose(400, 40 * kDeg, i, 0, 0, 0)}, seed).front();
    ASSERT_GT(slant.points, 0);
    tilted += slant.ambiguous ? 1 : 0;
    EXPECT_GT(slant.other_residual_px, slant.residual_px);
  }
  EXPECT_GE(frontal, 5);
  EXPECT_EQ(tilted, 0);
}

/// If it does not call a pose ambiguous, the tilt is the right one of the two.
TEST(MarkerFinderTest, AnUnambiguousPoseIsNeverTheOtherOne) {
  FinderBench bench({*marker_tool("marker:7:30")});
  int said = 0;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Matrix4d truth = pattern_pose(500 + 24.0 * i, (2 + 2 * i) * kDeg, 2.1 * i);
    const auto found = bench.find({truth}, static_cast<unsigned>(100 + i)).front();
    if (found.points == 0 || found.ambiguous) continue;
    ++said;
    const Eigen::Vector3d normal = found.camera_from_tool.col(2).head<3>();
    EXPECT_LT(std::acos(std::min(1.0, normal.dot(truth.col(2).head<3>()))) / kDeg, 6) << i;
  }
  EXPECT_GT(said, 10);
}

TEST(MarkerFinderTest, ImagesThatCannotBeUsedAreNamed) {
  FinderBench bench({*marker_tool("marker:7:40")});
  const auto finder = bench.finder();
  EXPECT_TRUE(test::rejects(finder->find(Image2d<std::uint8_t>(1, 1, {5})), ErrorCode::kUsage,
                            {"camera.yml", "1280 x 1024 pixels", "found 1 x 1 pixels"}));
  for (const int grey : {0, 128, 255}) {
    const auto even = finder->find(Image2d<std::uint8_t>(
        1280, 1024,
        std::vector<std::uint8_t>(std::size_t{1280} * 1024, static_cast<std::uint8_t>(grey))));
    ASSERT_TRUE(test::has_value(even));
    EXPECT_EQ(even->front().markers, 0);
  }
}

TEST(CameraModelTest, WhatIsWrongInACalibrationIsNamedByFileAndKey) {
  const test::TemporaryFolder folder;
  const auto file = folder / "camera.yml";
  test::TestCamera().write(file.string());
  std::ifstream stream(file);
  const std::string good{std::istreambuf_iterator<char>(stream), {}};
  ASSERT_TRUE(test::has_value(read_camera_model(file)));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    std::ofstream(file) << text.replace(at, from.size(), to);
    return read_camera_model(file);
  };
  const auto bad = [&](const std::string& from, const std::string& to,
                       std::initializer_list<std::string> words) {
    EXPECT_TRUE(test::rejects(changed(from, to), ErrorCode::kMalformedData, words));
  };
  bad("image_width", "width", {file.string(), "image_width", "found nothing"});
  bad("1280", "0", {file.string(), "image_width", "found 0"});
  bad("camera_matrix", "matrix", {"camera_matrix", "3 x 3", "found nothing"});
  bad("rows: 3\n   cols: 3", "rows: 1\n   cols: 9", {"camera_matrix", "1 x 9 numbers"});
  bad("1400, 0.", "-1400, 0.", {"camera_matrix", "above 0"});
  bad("1400, 0.", ".Nan, 0.", {"camera_matrix", "finite"});
  bad("rows: 5", "rows: 3", {"camera.yml"});
  bad("distortion_coefficients", "distortion", {"distortion_coefficients", "found nothing"});
  bad(good, "no yaml", {file.string(), "%YAML:1.0"});
  EXPECT_TRUE(test::rejects(read_camera_model(folder / "none.yml"), ErrorCode::kNotFound,
                            {"none.yml", "calibration"}));
}

/// Chessboard of a real camera: its corners are found again, and their pose is that of its
/// calibration.
TEST(MarkerFinderDataTest, CornersOfARealChessboardFitItsCalibration) {
  SONDE_REQUIRE_DATA(data, "aruco/bard-camera-calibration");
  const auto numbers = [&](const std::string& name) {
    std::ifstream file(data / name);
    std::vector<double> all;
    for (double number = 0; file >> number;) all.push_back(number);
    return all;
  };
  const auto k = numbers("calib.intrinsics.txt");
  ASSERT_EQ(k.size(), 9U);
  CvCameraModel camera{.file = "calib", .size = {640, 480}, .matrix = {}, .distortion = {}};
  camera.matrix = cv::Matx33d(k.data());
  camera.distortion = numbers("calib.distortion.txt");
  // The corners that the data give for images 10 and 11 miss theirs by up to half a square.
  constexpr int kGoodImages = 10;
  for (int i = 0; i < 12; ++i) {
    const std::string index = std::to_string(i) + ".txt";
    const cv::Mat image = cv::imread(
        (data / ("calib.images." + std::to_string(i) + ".png")).string(), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(image.empty());
    const auto pixels = numbers("calib.image_points." + index);
    const auto points = numbers("calib.object_points." + index);
    const auto truth = numbers("calib.extrinsics." + index);
    std::vector<cv::Point2d> refined, given;
    std::vector<cv::Point3d> of;
    for (std::size_t j = 0; 2 * j + 1 < pixels.size(); ++j) {
      const cv::Point2d corner(pixels[2 * j], pixels[2 * j + 1]);
      double nearest = 1e9;
      for (std::size_t other = 0; 2 * other + 1 < pixels.size(); ++other) {
        if (other == j) continue;
        nearest = std::min(
            nearest, cv::norm(cv::Point2d(pixels[2 * other], pixels[2 * other + 1]) - corner));
      }
      // From two thirds of a pixel beside it.
      const auto found = refine_saddle(image, corner + cv::Point2d(0.5, -0.4),
                                       std::clamp(0.35 * nearest, 2.0, 5.0));
      if (!found) continue;
      if (i < kGoodImages) {
        EXPECT_LT(cv::norm(*found - corner), 0.6) << i << ", corner " << j;
      }
      refined.push_back(*found);
      given.push_back(corner);
      of.emplace_back(points[3 * j], points[3 * j + 1], points[3 * j + 2]);
    }
    if (i >= kGoodImages) {
      EXPECT_LT(refined.size(), pixels.size() / 2 * 2 / 3) << i << ": found where no corner is";
      continue;
    }
    EXPECT_GE(refined.size(), pixels.size() / 2 * 9 / 10) << i;
    const auto pose = planar_pose(of, camera.directions(refined), camera.focal_px());
    const auto as_given = planar_pose(of, camera.directions(given), camera.focal_px());
    ASSERT_TRUE(pose && as_given) << i;
    // A printed board is not flat to the last pixel: its own corners fit no better.
    EXPECT_LT(pose->residual_px, 1.05 * as_given->residual_px) << i;
    EXPECT_FALSE(pose->ambiguous) << i;
    const cv::Vec3d t(truth[3], truth[7], truth[11]);
    EXPECT_LT(cv::norm(pose->translation_mm - t), 0.5) << i << ": by its calibration " << t;
  }
}

/// The photographs show many copies of one tag.
TEST(MarkerFinderDataTest, AMarkerThatIsSeenTwiceIsNotTaken) {
  SONDE_REQUIRE_DATA(photo, "aruco/apriltag/33369213973_9d9bb4cc96_c.jpg");
  const cv::Mat grey = cv::imread(photo.string(), cv::IMREAD_GRAYSCALE);
  ASSERT_FALSE(grey.empty());
  const test::TemporaryFolder folder;
  const test::TestCamera camera{.width = grey.cols, .height = grey.rows, .focal_px = 900};
  camera.write((folder / "camera.yml").string());
  auto finder = make_marker_finder({.tools = {*marker_tool("marker:0:100")},
                                    .dictionary = "apriltag_36h11",
                                    .camera = folder / "camera.yml"});
  ASSERT_TRUE(test::has_value(finder));
  const std::vector<std::uint8_t> pixels(grey.begin<std::uint8_t>(), grey.end<std::uint8_t>());
  const auto found = (*finder)->find({grey.cols, grey.rows, pixels});
  ASSERT_TRUE(test::has_value(found));
  EXPECT_EQ(found->front().markers, 0);
}

}  // namespace
}  // namespace nav::devices
