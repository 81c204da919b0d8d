// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/recorded_setup.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav::session {
namespace {

TEST(RecordedSetupTest, KeepsEveryBitOfItsMatrices) {
  SessionSetup setup;
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  setup.calibration =
      ProbeCalibration{Transform<frames::Probe, frames::Image>(turn, {1.0 / 3, -2e-7, 98.7})};
  setup.body_from_tip = Eigen::Matrix4d::Identity() / 3.0;
  setup.probe_from_pixels = Eigen::Matrix4d::Identity() * 0.1;
  setup.fixed_reference.emplace(turn.inverse(), Eigen::Vector3d(0.1, 0.2, 0.3));
  setup.navigator.pairing.temporal_offset = Duration(-12'345'678);
  const auto again = setup_from(facts_of(setup), "test");
  ASSERT_TRUE(test::has_value(again));
  EXPECT_EQ(again->calibration->probe_from_image.translation_mm(),
            setup.calibration->probe_from_image.translation_mm());
  EXPECT_EQ(again->calibration->probe_from_image.rotation().coeffs(),
            setup.calibration->probe_from_image.rotation().coeffs());
  EXPECT_EQ(*again->body_from_tip, *setup.body_from_tip);
  EXPECT_EQ(*again->probe_from_pixels, *setup.probe_from_pixels);
  EXPECT_TRUE(again->fixed_reference);
  EXPECT_EQ(again->navigator.pairing.temporal_offset, setup.navigator.pairing.temporal_offset);
  const auto nothing = setup_from({}, "test");
  ASSERT_TRUE(test::has_value(nothing));
  EXPECT_FALSE(nothing->calibration || nothing->probe_from_pixels || nothing->fixed_reference);
}

TEST(RecordedSetupTest, KeepsTheWatchOverAScreen) {
  SessionSetup setup;
  EXPECT_FALSE(setup_from(facts_of(setup), "test")->image_watch);
  setup.image_watch.emplace();
  const auto sector = setup_from(facts_of(setup), "test");
  ASSERT_TRUE(test::has_value(sector));
  ASSERT_TRUE(sector->image_watch);
  EXPECT_FALSE(sector->image_watch->depth_display);
  setup.image_watch->depth_display = ScreenArea{600, 10, 30, 20};
  const auto display = setup_from(facts_of(setup), "test");
  ASSERT_TRUE(test::has_value(display));
  ASSERT_TRUE(display->image_watch && display->image_watch->depth_display);
  EXPECT_EQ(display->image_watch->depth_display->left, 600);
  EXPECT_EQ(display->image_watch->depth_display->height, 20);
}

TEST(RecordedSetupTest, NamesTheFactThatIsNoTransform) {
  const auto error = [](const char* key, const char* value) {
    const auto made = setup_from({{key, value}}, "r.mcap");
    return made ? std::string() : made.error().message;
  };
  EXPECT_TRUE(error("probe_from_image", "2 0 0 0 1 2 3")
                  .starts_with("r.mcap: sonde.setup.probe_from_image: expected a unit quaternion"));
  EXPECT_NE(error("reference_from_tracker", "1 0 0 0 1 2"), "");
  EXPECT_EQ(error("probe_from_pixels_mm", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1"), "")
      << "pixels may be scaled";
  EXPECT_NE(error("probe_from_pixels_mm", "1 2 3"), "");
  EXPECT_NE(error("needle_body_from_tip_mm", "1 0 0 nan 0 1 0 0 0 0 1 0 0 0 0 1"), "");
  EXPECT_NE(error("temporal_offset_ns", "soon"), "");
  EXPECT_NE(error("temporal_offset_ns", "99000000000"), "") << "99 s";
  EXPECT_NE(error("screen_watch", "1 2 3"), "");
  EXPECT_NE(error("screen_watch", "1 2 0 4"), "");
  EXPECT_EQ(error("something_new", "of a later version"), "");
}

}  // namespace
}  // namespace nav::session
