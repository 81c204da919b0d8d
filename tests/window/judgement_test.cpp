// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/judgement.hpp"

#include <gtest/gtest.h>

#include "tests/window/moments.hpp"

namespace nav::app {
namespace {

using test::kMs;
using test::kStart;
using test::valid_moment;

TEST(JudgementTest, FreshInputsAreShownWithNumbers) {
  const auto moment = valid_moment(1, kStart);
  const Judgement now = judge(moment, moment, moment, {}, kStart + 90 * kMs);
  for (const ViewJudgement* view : {&now.ultrasound, &now.ct, &now.scene}) {
    EXPECT_FALSE(view->covered);
    EXPECT_EQ(view->safety.state, SafetyState::kValid);
  }
  ASSERT_TRUE(now.guidance);
  EXPECT_EQ(now.guidance->tip_to_target_mm, 12.3);
}

TEST(JudgementTest, AStaleImageIsCoveredAndItsNumbersAreWithdrawnAtOnce) {
  const auto shown = valid_moment(1, kStart);
  const auto newest = valid_moment(2, kStart);
  newest->epoch.ultrasound = newest->epoch.plane = {SafetyState::kStale, "no image"};
  newest->epoch.needle = {SafetyState::kLost, "the needle is not tracked"};
  newest->epoch.guidance.reset();
  const Judgement now = judge(newest, shown, shown, {}, kStart + 30 * kMs);
  EXPECT_TRUE(now.ultrasound.covered);
  EXPECT_EQ(now.ultrasound.headline, "ULTRASOUND STALE");
  EXPECT_TRUE(now.ct.covered);
  EXPECT_FALSE(now.guidance);
  EXPECT_EQ(now.withdrawn, "the needle is not tracked");
}

TEST(JudgementTest, ASessionThatHangsIsCoveredByTheWatchdog) {
  const auto moment = valid_moment(1, kStart);
  const auto end = kStart + 100 * kMs + kDrawingAllowance;
  EXPECT_FALSE(judge(moment, moment, moment, {}, end).ultrasound.covered);
  const Judgement now = judge(moment, moment, moment, {}, end + 1 * kMs);
  EXPECT_TRUE(now.ultrasound.covered);
  EXPECT_TRUE(now.ct.covered);
  EXPECT_TRUE(now.scene.covered);
  EXPECT_FALSE(now.guidance);
  EXPECT_EQ(now.withdrawn.substr(0, 22), "no new needle pose for");
}

TEST(JudgementTest, AnEngineThatHangsIsCoveredWhileTheOtherViewsGoOn) {
  const auto old = valid_moment(1, kStart);
  const auto fresh = valid_moment(9, kStart + 400 * kMs);
  const Judgement now = judge(fresh, fresh, old, {}, kStart + 420 * kMs);
  EXPECT_TRUE(now.scene.covered);
  EXPECT_EQ(now.scene.headline, "3D VIEW STALE");
  EXPECT_FALSE(now.ultrasound.covered);
  EXPECT_TRUE(now.guidance);
}

TEST(JudgementTest, ALateThreeDViewIsNamed) {
  const auto old = valid_moment(1, kStart);
  const auto fresh = valid_moment(2, kStart + 50 * kMs);
  EXPECT_TRUE(judge(fresh, fresh, old, {}, kStart + 80 * kMs).scene.late);
}

TEST(JudgementTest, ACtWithoutLiveImageIsNotCoveredUnlessTheEngineStandsStill) {
  const auto old = valid_moment(1, kStart);
  old->epoch.plane = old->epoch.needle = {SafetyState::kLost, "nothing"};
  const auto fresh = valid_moment(2, kStart + 1000 * kMs);
  EXPECT_FALSE(judge(old, old, old, {}, kStart + std::chrono::hours(1)).scene.covered);
  EXPECT_FALSE(judge(fresh, fresh, old, {}, kStart + 1000 * kMs).scene.covered);
  EXPECT_TRUE(
      judge(fresh, fresh, old, {}, kStart + 20 * kMs + kLongestLate + 1 * kMs).scene.covered);
}

TEST(JudgementTest, AFailedEngineIsNamed) {
  const auto moment = valid_moment(1, kStart);
  const Judgement now = judge(moment, moment, moment, {.scene = "no memory"}, kStart);
  EXPECT_TRUE(now.scene.covered);
  EXPECT_EQ(now.scene.safety.cause, "no memory");
}

TEST(JudgementTest, SlicesShowTheCtWhenThePlaneIsStaleAndSayIt) {
  const auto shown = valid_moment(2, kStart);
  shown->epoch.ultrasound = shown->epoch.plane = {SafetyState::kStale, "no image"};
  shown->epoch.needle = {SafetyState::kStale, "old pose"};
  shown->epoch.guidance.reset();
  const Judgement now = judge(shown, shown, shown, {}, kStart + std::chrono::seconds(10));
  EXPECT_FALSE(now.slices.covered);
  EXPECT_EQ(now.slices.safety.state, SafetyState::kStale);
  EXPECT_EQ(now.slices.about, "plane");
  EXPECT_FALSE(now.scene.covered);
  EXPECT_EQ(now.scene.about, "plane") << "the 3D view shows the CT, which is not stale";
  EXPECT_TRUE(now.needle.covered) << "slices along a needle that is not there any more";
  EXPECT_TRUE(now.bullseye.covered);
}

TEST(JudgementTest, SlicesWithAnOldLineOfThePlaneAreCovered) {
  const auto moment = valid_moment(1, kStart);
  const auto end = kStart + 100 * kMs + kDrawingAllowance;
  EXPECT_FALSE(judge(moment, moment, moment, {}, end).slices.covered);
  const Judgement now = judge(moment, moment, moment, {}, end + 1 * kMs);
  EXPECT_TRUE(now.slices.covered && now.needle.covered && now.bullseye.covered);
  EXPECT_EQ(now.slices.headline, "SLICE STALE");
  EXPECT_EQ(now.slices.about, "") << "the whole view is stale";
}

TEST(JudgementTest, ABullsEyeIsCoveredWithoutNumbers) {
  const auto moment = valid_moment(1, kStart);
  EXPECT_FALSE(judge(moment, moment, moment, {}, kStart + 30 * kMs).bullseye.covered);
  moment->epoch.guidance.reset();
  const Judgement now = judge(moment, moment, moment, {}, kStart + 30 * kMs);
  EXPECT_FALSE(now.needle.covered);
  EXPECT_TRUE(now.bullseye.covered);
  EXPECT_EQ(now.bullseye.headline, "BULL'S-EYE WITHDRAWN");
  EXPECT_EQ(now.bullseye.safety.cause, "no plan: no target");
}

TEST(JudgementTest, WithoutASessionEverythingIsCovered) {
  const Judgement now = judge(nullptr, nullptr, nullptr, {}, kStart);
  EXPECT_TRUE(now.ultrasound.covered && now.ct.covered && now.scene.covered);
  EXPECT_FALSE(now.guidance);
}

TEST(JudgementTest, DistancesFromStructuresOfAnOlderPlanAreWithdrawn) {
  using State = session::NearestStructure::State;
  const auto moment = valid_moment(1, kStart);
  moment->structures = 3;
  moment->nearest = session::NearestStructure{State::kKnown, 4, "vessel", ""};
  const Judgement now = judge(moment, moment, moment, {}, kStart + 30 * kMs, 3);
  ASSERT_TRUE(now.nearest);
  EXPECT_EQ(now.nearest->state, State::kKnown);
  const Judgement edited = judge(moment, moment, moment, {}, kStart + 30 * kMs, 4);
  ASSERT_TRUE(edited.nearest);
  EXPECT_EQ(edited.nearest->state, State::kPending);
  const auto lost = valid_moment(2, kStart);
  lost->epoch.guidance.reset();
  lost->epoch.needle = {SafetyState::kLost, "the needle is not tracked"};
  EXPECT_FALSE(judge(lost, moment, moment, {}, kStart + 30 * kMs, 3).nearest);
}

}  // namespace
}  // namespace nav::app
