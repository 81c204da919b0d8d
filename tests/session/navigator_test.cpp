// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/navigator.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav::session {
namespace {

using std::chrono::milliseconds;

Timestamp ms(int value) { return Timestamp(milliseconds(value)); }

RawPose pose(int acquired_ms, const Eigen::Vector3d& position_mm,
             TrackingStatus status = TrackingStatus::kOk) {
  RawPose raw{ms(acquired_ms), ms(acquired_ms), status, Eigen::Matrix4d::Identity()};
  raw.tracker_from_body.topRightCorner<3, 1>() = position_mm;
  return raw;
}

UltrasoundImage image(std::uint64_t sequence, int acquired_ms) {
  return {.acquired = ms(acquired_ms),
          .received = ms(acquired_ms),
          .sequence = sequence,
          .pixels = Image2d<std::uint8_t>(2, 2, {1, 2, 3, 4}),
          .grid = PixelGrid::centred(2, 1, 1)};
}

class NavigatorTest : public ::testing::Test {
 protected:
  NavigatorTest()
      : navigator_(ProbeCalibration{Transform<frames::Probe, frames::Image>(
                       Eigen::Quaterniond::Identity(), {0, 0, 0})},
                   std::nullopt, {}, diagnostics_) {
    navigator_.set_plan({{{0, 0, 0}}, {{0, 0, 100}}, 5, 5});
  }
  void feed(int from_ms, int to_ms) {
    for (int t = from_ms; t <= to_ms; t += 10) {
      navigator_.add_pose(ToolRole::kProbe, pose(t, {0, 0, 0}));
      navigator_.add_pose(ToolRole::kReference, pose(t, {0, 0, 0}));
      navigator_.add_pose(ToolRole::kNeedle, pose(t, {0, 0, 40}));
    }
  }
  Epoch refresh(int now_ms) {
    navigator_.settle(ms(now_ms), false, [](const auto&) {});
    return navigator_.refresh(ms(now_ms));
  }
  void place(SafetyState state, const std::string& cause) {
    navigator_.set_placement(
        {Transform<frames::Ct, frames::Reference>(Eigen::Quaterniond::Identity(), {0, 0, 0}),
         {state, cause}});
  }
  CollectingDiagnostics diagnostics_;
  Navigator navigator_;
};

TEST_F(NavigatorTest, ShowsNumbersOnlyWhileTheWholeChainIsValid) {
  feed(0, 100);
  navigator_.add_image(image(1, 95));
  Epoch epoch = refresh(100);
  EXPECT_EQ(epoch.plane.state, SafetyState::kLost) << "not registered";
  EXPECT_FALSE(epoch.ct_from_image);
  EXPECT_FALSE(epoch.guidance);

  place(SafetyState::kDegraded, "placed by declaration");
  epoch = refresh(101);
  EXPECT_EQ(epoch.plane.state, SafetyState::kDegraded);
  EXPECT_EQ(epoch.plane.cause, "placed by declaration");
  EXPECT_FALSE(epoch.guidance) << "no numbers from a declared placement";

  place(SafetyState::kValid, "");
  epoch = refresh(102);
  EXPECT_EQ(epoch.plane.state, SafetyState::kValid);
  ASSERT_TRUE(epoch.guidance);
  EXPECT_NEAR(epoch.guidance->tip_to_target_mm, 60, 1e-9);
}

TEST_F(NavigatorTest, AReferenceWithoutAStatusDegradesTheNeedleToo) {
  place(SafetyState::kValid, "");
  for (int t = 0; t <= 100; t += 10) {
    navigator_.add_pose(ToolRole::kProbe, pose(t, {0, 0, 0}));
    navigator_.add_pose(ToolRole::kReference, pose(t, {0, 0, 0}, TrackingStatus::kUnknown));
    navigator_.add_pose(ToolRole::kNeedle, pose(t, {0, 0, 40}));
  }
  navigator_.add_image(image(1, 95));
  const Epoch epoch = refresh(100);
  EXPECT_EQ(epoch.ultrasound.state, SafetyState::kDegraded);
  EXPECT_EQ(epoch.needle.state, SafetyState::kDegraded);
  EXPECT_EQ(epoch.needle.cause, "the tracker gave no status for the patient reference");
  EXPECT_FALSE(epoch.guidance);
}

TEST_F(NavigatorTest, TellsWhereTheNeedleWas) {
  place(SafetyState::kValid, "");
  for (int t = 0; t <= 100; t += 10) {
    navigator_.add_pose(ToolRole::kReference, pose(t, {0, 0, 0.5 * t}));
    navigator_.add_pose(ToolRole::kNeedle, pose(t, {0.1 * t, 0, 0}));
  }
  const auto then = navigator_.needle_at(ms(45));
  ASSERT_TRUE(then);
  EXPECT_LT((then->translation_mm() - Eigen::Vector3d(4.5, 0, -22.5)).norm(), 1e-9);
  EXPECT_FALSE(navigator_.needle_at(ms(500)));
}

TEST_F(NavigatorTest, NothingIsLiveAtTheEnd) {
  place(SafetyState::kValid, "");
  feed(0, 100);
  navigator_.add_image(image(1, 95));
  Epoch epoch = refresh(100);
  ASSERT_TRUE(epoch.guidance);
  epoch.plane = {SafetyState::kLost, "far away"};
  const Epoch over = ended(epoch, "the end");
  EXPECT_EQ(over.ultrasound.state, SafetyState::kStale);
  EXPECT_EQ(over.ultrasound.cause, "the end");
  EXPECT_EQ(over.needle.state, SafetyState::kStale);
  EXPECT_EQ(over.plane.state, SafetyState::kLost) << "and is not drawn again";
  EXPECT_FALSE(over.guidance);
}

TEST_F(NavigatorTest, AnEpochThatIsStillShownAges) {
  place(SafetyState::kValid, "");
  feed(0, 100);
  navigator_.add_image(image(1, 100));
  const Epoch live = refresh(100);
  ASSERT_EQ(live.plane.state, SafetyState::kValid);
  ASSERT_TRUE(live.guidance);
  // Images are stale after two periods of 50 ms, lost after five times that; needles after 40 ms.
  const Epoch soon = navigator_.aged(live, ms(140));
  EXPECT_EQ(soon.plane.state, SafetyState::kValid);
  EXPECT_TRUE(soon.guidance);
  EXPECT_FALSE(soon.frame_is_new);
  const Epoch later = navigator_.aged(live, ms(141));
  EXPECT_EQ(later.needle.state, SafetyState::kStale);
  EXPECT_FALSE(later.guidance) << "numbers are withdrawn";
  EXPECT_EQ(later.plane.state, SafetyState::kValid);
  EXPECT_EQ(navigator_.aged(live, ms(201)).plane.state, SafetyState::kStale);
  EXPECT_EQ(navigator_.aged(live, ms(201)).ultrasound.state, SafetyState::kStale);
  const Epoch lost = navigator_.aged(later, ms(601));
  EXPECT_EQ(lost.plane.state, SafetyState::kLost);
  EXPECT_EQ(lost.needle.state, SafetyState::kLost);
}

TEST_F(NavigatorTest, WithdrawsNumbersWhenTheNeedleGrowsStale) {
  place(SafetyState::kValid, "");
  feed(0, 100);
  EXPECT_TRUE(refresh(140).guidance) << "40 ms: two periods";
  const Epoch stale = refresh(141);
  EXPECT_EQ(stale.needle.state, SafetyState::kStale);
  EXPECT_FALSE(stale.guidance);
  EXPECT_TRUE(stale.ct_from_needle) << "still there to be ghosted";
  EXPECT_EQ(refresh(500).needle.state, SafetyState::kLost);
}

TEST_F(NavigatorTest, AnOccludedNeedleIsNeverShownAtItsLastPose) {
  place(SafetyState::kValid, "");
  feed(0, 100);
  RawPose occluded = pose(110, {0, 0, 0});
  occluded.status = TrackingStatus::kOccluded;
  navigator_.add_pose(ToolRole::kNeedle, occluded);
  const Epoch epoch = refresh(110);
  EXPECT_EQ(epoch.needle.state, SafetyState::kLost);
  EXPECT_FALSE(epoch.ct_from_needle);
  EXPECT_FALSE(epoch.guidance);
  EXPECT_EQ(navigator_.rejected_poses().at("Needle.status_not_ok"), 1u);
}

TEST_F(NavigatorTest, AnOldImageIsStaleThenLost) {
  place(SafetyState::kValid, "");
  feed(0, 100);
  navigator_.add_image(image(1, 100));
  EXPECT_EQ(refresh(120).plane.state, SafetyState::kValid);
  EXPECT_EQ(refresh(201).plane.state, SafetyState::kStale);
  EXPECT_EQ(refresh(700).plane.state, SafetyState::kLost);
}

TEST_F(NavigatorTest, AnImageThatRepeatsIsAsOldAsWhatItShows) {
  place(SafetyState::kValid, "");
  for (int t = 0; t <= 400; t += 10) {
    navigator_.add_pose(ToolRole::kProbe, pose(t, {0.1 * t, 0, 0}));
    navigator_.add_pose(ToolRole::kReference, pose(t, {0, 0, 0}));
  }
  // Equal pixels while the probe moves by 100 mm/s; an image of 20 Hz is stale after 100 ms.
  std::vector<SafetyState> states;
  for (int i = 0; i < 6; ++i) {
    navigator_.add_image(image(static_cast<std::uint64_t>(i), 50 + 50 * i));
    const Epoch epoch = refresh(50 + 50 * i);
    ASSERT_TRUE(epoch.frame);
    states.push_back(epoch.ultrasound.state);
    if (i > 2) {
      EXPECT_NE(epoch.ultrasound.cause.find("the scanner is frozen"), std::string::npos);
      EXPECT_EQ(epoch.plane.state, SafetyState::kStale);
    }
  }
  using enum SafetyState;
  EXPECT_EQ(states, (std::vector{kValid, kDegraded, kDegraded, kStale, kStale, kStale}));
}

TEST_F(NavigatorTest, ADoubtfulCalibrationDegradesItsImages) {
  const ProbeCalibration calibration{
      .probe_from_image =
          Transform<frames::Probe, frames::Image>(Eigen::Quaterniond::Identity(), {0, 0, 0}),
      .doubt = "ImageToProbe: the identity (is the probe calibrated?)"};
  Navigator navigator(calibration, std::nullopt, {}, diagnostics_);
  for (int t = 0; t <= 100; t += 10) {
    navigator.add_pose(ToolRole::kProbe, pose(t, {0, 0, 0}));
    navigator.add_pose(ToolRole::kReference, pose(t, {0, 0, 0}));
  }
  navigator.add_image(image(0, 50));
  navigator.settle(ms(60), false, [](const auto&) {});
  const Epoch epoch = navigator.refresh(ms(60));
  EXPECT_EQ(epoch.ultrasound.state, SafetyState::kDegraded);
  EXPECT_EQ(epoch.ultrasound.cause, calibration.doubt);
}

TEST_F(NavigatorTest, AccountsForEveryImage) {
  feed(0, 100);
  for (int i = 0; i < 5; ++i) {
    navigator_.add_image(image(static_cast<std::uint64_t>(i), 20 * i));
  }
  navigator_.add_image(image(9, 0));  // Backwards in time.
  navigator_.add_missing({"no_image", "0 x 0"});
  EXPECT_TRUE(refresh(100).frame_is_new);
  EXPECT_FALSE(refresh(101).frame_is_new) << "the same image is not shown twice";
  navigator_.add_image(image(11, 95));
  navigator_.settle(ms(102), true, [](const auto&) {});
  navigator_.finish();
  const auto& ledger = navigator_.ledger();
  EXPECT_EQ(ledger.received(), 8u);
  EXPECT_EQ(ledger.delivered(), 1u);
  EXPECT_EQ(ledger.superseded(), 5u);
  EXPECT_EQ(ledger.rejected().at("time_not_increasing"), 1u);
  EXPECT_EQ(ledger.rejected().at("no_image"), 1u);
  EXPECT_TRUE(ledger.balanced());
}

TEST_F(NavigatorTest, SaysWhatIsWrongWithTheDevice) {
  navigator_.set_placement(
      {{Eigen::Quaterniond::Identity(), {0, 0, 0}}, {SafetyState::kValid, ""}});
  feed(0, 100);
  navigator_.add_image(image(1, 100));
  navigator_.settle(ms(100), false, [](const tracking::PairedImage&) {});
  navigator_.set_trouble(true, ToolRole::kOther, "the device is not there (no_listener)");
  EXPECT_EQ(navigator_.refresh(ms(110)).ultrasound.state, SafetyState::kValid);
  const Safety stale = navigator_.refresh(ms(2000)).ultrasound;
  EXPECT_EQ(stale.state, SafetyState::kLost);
  EXPECT_TRUE(stale.cause.starts_with("images: the device is not there (no_listener); "))
      << stale.cause;
  navigator_.set_trouble(true, ToolRole::kOther, "");
  navigator_.add_missing({"late", "an image was late"});
  EXPECT_NE(navigator_.refresh(ms(2010)).ultrasound.cause.find("rejected: data came late"),
            std::string::npos);
}

}  // namespace
}  // namespace nav::session
