// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "devices/camera/frame_grabber_source.hpp"
#include "devices/camera/marker_source.hpp"
#include "tests/devices/marker_renderer.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// Films in the place of cameras, through OpenCV.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;

/// Samples of a source until its film has ended.
std::vector<Sample> all_of(PolledSource& source, const Clock& clock) {
  std::vector<Sample> all;
  const Timestamp end = clock.now() + std::chrono::seconds(60);
  while (clock.now() < end) {
    auto got = source.next(clock.now() + milliseconds(50));
    if (got) {
      all.push_back(*std::move(got));
    } else if (source.health().state == SourceState::kEnded) {
      break;
    }
  }
  return all;
}

VideoOpener film(const std::string& path, double rate_hz) {
  return [=] { return open_video({.path = path, .is_device = false, .rate_hz = rate_hz}); };
}

TEST(CameraFilmTest, PosesOfNumberedImagesAreThoseThatWereDrawn) {
  const test::TemporaryFolder folder;
  test::TestCamera camera{
      .width = 640, .height = 480, .focal_px = 700, .centre_x = 320, .centre_y = 240};
  camera.write((folder / "camera.yml").string());
  const MarkerTool tool = *marker_tool("marker:3:40");
  std::vector<Eigen::Matrix4d> truth;
  for (int i = 0; i < 4; ++i) {
    truth.push_back(test::pattern_pose(300 + 20 * i, 0.5, 0.7 * i, 0.2 * i, 10.0 * i, -5.0 * i));
    test::MarkerRenderer renderer(camera, 0, static_cast<unsigned>(i));
    renderer.add(tool, truth.back());
    const auto image = renderer.image();
    std::vector<std::uint8_t> pixels(image.pixels().begin(), image.pixels().end());
    char name[32];
    std::snprintf(name, sizeof name, "frame_%03d.png", i);
    ASSERT_TRUE(cv::imwrite((folder / name).string(), cv::Mat(480, 640, CV_8U, pixels.data())));
  }
  const MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  auto finder = make_marker_finder({.tools = {tool}, .camera = folder / "camera.yml"});
  ASSERT_TRUE(test::has_value(finder));
  auto source = MarkerSource::create({.streams = {{"Probe", ToolRole::kProbe}}}, "film",
                                     film((folder / "frame_%03d.png").string(), 100),
                                     *std::move(finder), clock, diagnostics);
  ASSERT_TRUE(test::has_value(source));
  const auto samples = all_of(**source, clock);
  ASSERT_EQ(samples.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto& pose = std::get<PoseSample>(samples[i].what);
    EXPECT_EQ(pose.pose.status, TrackingStatus::kOk) << i;
    const Eigen::Vector4d off = (pose.pose.tracker_from_body - truth[i]).col(3);
    EXPECT_LT(off.norm(), 0.5) << i;
    EXPECT_GE(samples[i].received - samples.front().received, (i * milliseconds(10)) / 2);
  }
  EXPECT_EQ((*source)->health().cause, "film_ended");
}

TEST(CameraFilmTest, AnAviGivesItsImages) {
  const test::TemporaryFolder folder;
  const std::string path = (folder / "film.avi").string();
  {
    cv::VideoWriter writer(path, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                           50, {64, 48});
    ASSERT_TRUE(writer.isOpened());
    for (const int grey : {40, 90, 200}) {
      writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar(grey, grey, grey)));
    }
  }
  const MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  auto source = FrameGrabberSource::create({.crop = PixelArea{8, 4, 40, 30}}, "film",
                                           film(path, 200), clock, diagnostics);
  ASSERT_TRUE(test::has_value(source));
  const auto samples = all_of(**source, clock);
  ASSERT_EQ(samples.size(), 3U);
  const std::array greys = {40, 90, 200};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& image = std::get<UltrasoundImage>(samples[i].what);
    EXPECT_EQ(image.pixels.width(), 40);
    EXPECT_EQ(image.sequence, i);
    EXPECT_NEAR(image.pixels.at(20, 15), greys[i], 3);
  }
}

TEST(CameraFilmTest, ColoursOfTheScreenStayInTheCrop) {
  const test::TemporaryFolder folder;
  cv::Mat screen(6, 8, CV_8UC3, cv::Scalar(40, 40, 40));
  screen.at<cv::Vec3b>(2, 3) = {0, 0, 255};  // OpenCV's order is blue, green, red.
  screen.at<cv::Vec3b>(4, 5) = {255, 10, 0};
  ASSERT_TRUE(cv::imwrite((folder / "frame_000.png").string(), screen));
  const std::string path = (folder / "frame_%03d.png").string();
  const auto first_of = [&](const PixelArea& crop, bool colours) {
    const MonotonicClock clock;
    CollectingDiagnostics diagnostics;
    const auto open = [=] {
      return open_video({.path = path, .is_device = false, .rate_hz = 200, .colours = colours});
    };
    auto source = FrameGrabberSource::create({.crop = crop}, "film", open, clock, diagnostics);
    EXPECT_TRUE(test::has_value(source));
    const auto samples = all_of(**source, clock);
    EXPECT_EQ(samples.size(), 1U);
    return std::get<UltrasoundImage>(samples.at(0).what);
  };
  const UltrasoundImage image = first_of({.left = 3, .top = 1, .width = 4, .height = 4}, true);
  ASSERT_EQ(image.colours.width(), 4);
  ASSERT_EQ(image.colours.height(), 4);
  EXPECT_EQ(image.colours.at(0, 1), (Rgb8{255, 0, 0}));
  EXPECT_EQ(image.colours.at(2, 3), (Rgb8{0, 10, 255}));
  EXPECT_EQ(image.colours.at(1, 1), (Rgb8{40, 40, 40}));
  EXPECT_EQ(image.pixels.at(0, 1), luma(Rgb8{255, 0, 0}));
  EXPECT_TRUE(first_of({.left = 0, .top = 0, .width = 3, .height = 6}, true).colours.empty())
      << "the crop is grey";
  EXPECT_TRUE(first_of({.left = 3, .top = 1, .width = 4, .height = 4}, false).colours.empty());
}

TEST(CameraFilmTest, AFilmOfARealCameraIsRead) {
  SONDE_REQUIRE_DATA(path, "aruco/scikit-surgery/multipattern.avi");
  const MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  auto source =
      FrameGrabberSource::create({}, "film", film(path.string(), 500), clock, diagnostics);
  ASSERT_TRUE(test::has_value(source));
  const auto samples = all_of(**source, clock);
  EXPECT_GE(samples.size(), 10U);
  for (const Sample& sample : samples) {
    EXPECT_EQ(std::get<UltrasoundImage>(sample.what).pixels.width(), 640);
  }
}

TEST(CameraFilmTest, WhatIsNoCameraOrFilmIsNamed) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(test::rejects(open_video({.path = "/nonexistent/video0"}), ErrorCode::kNotFound,
                            {"/nonexistent/video0", "plug it in"}));
  EXPECT_TRUE(test::rejects(open_video({.path = "/dev/null"}), ErrorCode::kUnavailable,
                            {"/dev/null", "expected a camera"}));
  const auto text = folder / "film.avi";
  std::ofstream(text) << "no film";
  EXPECT_TRUE(test::rejects(open_video({.path = text.string(), .is_device = false}),
                            ErrorCode::kNotFound, {text.string(), "expected a film"}));
  EXPECT_TRUE(
      test::rejects(open_video({.path = (folder / "none_%03d.png").string(), .is_device = false}),
                    ErrorCode::kNotFound, {"none_%03d.png"}));
}

}  // namespace
}  // namespace nav::devices
