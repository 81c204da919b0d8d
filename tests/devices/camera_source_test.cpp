// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/devices/camera_rigs.hpp"
#include "tests/devices/source_bench.hpp"
#include "tests/support/matchers.hpp"

/// Sources of cameras, without a driver.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;

struct CameraBench : SourceBench<PolledSource> {
  void track(std::vector<MarkerStream> bodies) {
    auto made = std::make_unique<FixedFinder>(bodies.size());
    finder = made.get();
    source = *MarkerSource::create({.streams = std::move(bodies)}, "camera", camera.opener(),
                                   std::move(made), clock, diagnostics);
  }
  void grab(std::optional<PixelArea> crop = {}) {
    source =
        *FrameGrabberSource::create({.crop = crop}, "grabber", camera.opener(), clock, diagnostics);
  }
  FakeCamera camera;
  FixedFinder* finder = nullptr;  ///< The finder of the source.
};

const PoseSample& camera_pose_of(const Sample& sample) { return std::get<PoseSample>(sample.what); }

TEST(MarkerSourceTest, EveryImageGivesASampleOfEveryBodyAtOneTime) {
  CameraBench bench;
  bench.track({{"Probe", ToolRole::kProbe}, {"Reference", ToolRole::kReference}});
  const auto probe = bench.sample(), reference = bench.sample();
  ASSERT_TRUE(probe && reference);
  EXPECT_EQ(probe->stream, 0U);
  EXPECT_EQ(reference->stream, 1U);
  EXPECT_EQ(probe->sequence, reference->sequence);
  EXPECT_EQ(camera_pose_of(*probe).pose.acquired, camera_pose_of(*reference).pose.acquired);
  EXPECT_EQ(camera_pose_of(*probe).pose.status, TrackingStatus::kOk);
  EXPECT_EQ(camera_pose_of(*probe).tracker_error_mm, 0.2);
}

TEST(MarkerSourceTest, TheStampOfTheDriverIsTheTimeOfTheImage) {
  CameraBench bench;
  bench.camera.age = Duration(milliseconds(30)).count();
  bench.track({{"Probe"}});
  const auto got = bench.sample();
  ASSERT_TRUE(got);
  EXPECT_EQ(got->received - camera_pose_of(*got).pose.acquired, milliseconds(30));
}

TEST(MarkerSourceTest, WhatCannotBeKnownHasItsStatusAndNoMatrix) {
  CameraBench bench;
  bench.track({{"Probe"}, {"Hidden"}, {"Wrong"}});
  bench.finder->readings[0].ambiguous = true;
  bench.finder->readings[1] = {};
  bench.finder->readings[2].residual_px = 7;
  std::vector<Sample> got;
  got.reserve(6);
  for (int i = 0; i < 6; ++i) got.push_back(*bench.sample());
  EXPECT_EQ(camera_pose_of(got[0]).pose.status, TrackingStatus::kUnknown);
  EXPECT_TRUE(camera_pose_of(got[0]).pose.tracker_from_body.allFinite());
  EXPECT_EQ(camera_pose_of(got[1]).pose.status, TrackingStatus::kOccluded);
  EXPECT_FALSE(camera_pose_of(got[1]).pose.tracker_from_body.allFinite());
  EXPECT_EQ(camera_pose_of(got[2]).pose.status, TrackingStatus::kInvalid);
  EXPECT_FALSE(camera_pose_of(got[2]).pose.tracker_from_body.allFinite());
  const auto bad = bench.source->health().bad_messages;
  EXPECT_GE(bad.at("ambiguous"), 2U);
  EXPECT_GE(bad.at("bad_fit"), 2U);
  const std::string all = bench.reports();
  EXPECT_NE(all.find("Probe: its flat pattern may be tilted either way"), std::string::npos) << all;
  EXPECT_NE(all.find("Wrong: the corners of its markers lie 7 pixels"), std::string::npos) << all;
}

TEST(MarkerSourceTest, AnImageThatRepeatsIsNotNew) {
  CameraBench bench;
  bench.track({{"Probe"}});
  ASSERT_TRUE(bench.sample());
  bench.camera.repeats = true;
  EXPECT_TRUE(bench.until([](const auto& h) { return h.bad_messages.contains("repeated_image"); }));
  const auto counted = bench.source->health().bad_messages["repeated_image"];
  EXPECT_TRUE(bench.until(
      [&](const auto& h) { return h.bad_messages.at("repeated_image") > counted + 5; }));
  EXPECT_EQ(bench.source->health().state, SourceState::kStreaming);
}

TEST(MarkerSourceTest, AnotherFormatInTheMiddleIsNamedOnceAndGivesNoPose) {
  CameraBench bench;
  bench.track({{"Probe"}});
  ASSERT_TRUE(bench.sample());
  bench.camera.width = 10;
  std::optional<Sample> got;
  do {
    got = bench.sample();
    ASSERT_TRUE(got);
  } while (camera_pose_of(*got).pose.status == TrackingStatus::kOk);
  EXPECT_EQ(camera_pose_of(*got).pose.status, TrackingStatus::kInvalid);
  bench.camera.width = 8;
  do {
    got = bench.sample();
    ASSERT_TRUE(got);
  } while (camera_pose_of(*got).pose.status != TrackingStatus::kOk);
  const std::string all = bench.reports();
  EXPECT_NE(all.find("camera.yml"), std::string::npos) << all;
  EXPECT_EQ(all.find("camera.yml"), all.rfind("camera.yml")) << all;
}

TEST(FrameGrabberSourceTest, GivesTheCropAndSaysThatItsSpacingIsNotKnown) {
  CameraBench bench;
  bench.camera.age = Duration(milliseconds(20)).count();
  bench.grab(PixelArea{.left = 2, .top = 1, .width = 5, .height = 4});
  const auto got = bench.sample();
  ASSERT_TRUE(got);
  const auto& image = std::get<UltrasoundImage>(got->what);
  EXPECT_EQ(image.pixels.width(), 5);
  EXPECT_EQ(image.pixels.height(), 4);
  EXPECT_EQ(got->received - image.acquired, milliseconds(20));
  EXPECT_TRUE(image.grid.mm_per_pixel.isApprox(Eigen::Matrix2d::Identity()));
}

TEST(FrameGrabberSourceTest, AnImageWithoutTheCropIsAMissingImage) {
  CameraBench bench;
  bench.grab(PixelArea{.left = 4, .top = 0, .width = 5, .height = 4});
  const auto got = bench.sample();
  ASSERT_TRUE(got);
  ASSERT_TRUE(std::holds_alternative<MissingImage>(got->what));
  EXPECT_EQ(std::get<MissingImage>(got->what).cause, "crop");
  EXPECT_NE(bench.reports().find("5 x 4 pixels at 4, 0, found 8 x 6"), std::string::npos)
      << bench.reports();
}

TEST(FrameGrabberSourceTest, ASourceOfOnePixelIsAnImage) {
  CameraBench bench;
  bench.camera.width = bench.camera.height = 1;
  bench.grab();
  const auto got = bench.sample();
  ASSERT_TRUE(got);
  EXPECT_EQ(std::get<UltrasoundImage>(got->what).pixels.width(), 1);
}

TEST(CameraOptionsTest, ImpossibleOptionsAreNamed) {
  EXPECT_TRUE(test::rejects(validate(FrameGrabberOptions{.crop = PixelArea{0, 0, 0, 5}}),
                            ErrorCode::kUsage, {"crop", "[0, 0, 0, 5]"}));
  EXPECT_TRUE(test::rejects(validate(FrameGrabberOptions{.image = ""}), ErrorCode::kUsage,
                            {"name of the images"}));
  EXPECT_TRUE(test::rejects(validate(MarkerSourceOptions{}), ErrorCode::kUsage, {"one body"}));
  EXPECT_TRUE(test::rejects(
      validate(MarkerSourceOptions{.streams = {{"Probe"}}, .times = {.silence = Duration(0)}}),
      ErrorCode::kUsage, {"times above 0"}));
}

}  // namespace
}  // namespace nav::devices
