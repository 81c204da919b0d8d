// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/pose_buffer.hpp"

#include <gtest/gtest.h>

namespace nav::tracking {
namespace {

using frames::Probe;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr double kBufferRoundingMm = 1e-12;

TrackedPose<Probe> pose_at(int ms, double x_mm, TrackingStatus status = TrackingStatus::kOk) {
  return {Timestamp(milliseconds(ms)), status,
          Transform<frames::Tracker, Probe>(Eigen::Quaterniond::Identity(), {x_mm, 0, 0})};
}
TrackedPose<Probe> occluded_at(int ms) {
  return {Timestamp(milliseconds(ms)), TrackingStatus::kOccluded, std::nullopt};
}
Timestamp ms(int value) { return Timestamp(milliseconds(value)); }

PoseAbsence absence(const PoseBuffer<Probe>& buffer, Timestamp time) {
  return std::get<PoseAbsence>(buffer.at(time));
}

TEST(PoseBufferTest, InterpolatesBetweenNeighbours) {
  PoseBuffer<Probe> buffer;
  buffer.push(pose_at(0, 0));
  buffer.push(pose_at(20, 10));
  const auto at = std::get<PoseAt<Probe>>(buffer.at(ms(5)));
  EXPECT_NEAR(at.tracker_from_body.translation_mm().x(), 2.5, kBufferRoundingMm);
  EXPECT_EQ(at.gap, milliseconds(5));
  EXPECT_EQ(std::get<PoseAt<Probe>>(buffer.at(ms(18))).gap, milliseconds(2));
  EXPECT_EQ(std::get<PoseAt<Probe>>(buffer.at(ms(20))).gap, milliseconds(0));
}

TEST(PoseBufferTest, TheOnlyPoseIsDoubtfulUntilASecondOneComes) {
  PoseBuffer<Probe> buffer;
  buffer.push(occluded_at(0));
  buffer.push(pose_at(20, 10));
  EXPECT_EQ(std::get<PoseAt<Probe>>(buffer.at(ms(20))).doubt, PoseDoubt::kOnly);
  buffer.push(pose_at(40, 10));
  EXPECT_EQ(std::get<PoseAt<Probe>>(buffer.at(ms(20))).doubt, PoseDoubt::kNone);
  EXPECT_EQ(std::get<PoseAt<Probe>>(buffer.at(ms(40))).doubt, PoseDoubt::kNone);
}

TEST(PoseBufferTest, DoesNotExtrapolate) {
  PoseBuffer<Probe> buffer;
  EXPECT_EQ(absence(buffer, ms(0)), PoseAbsence::kNotYet);
  buffer.push(pose_at(10, 0));
  buffer.push(pose_at(20, 1));
  EXPECT_EQ(absence(buffer, ms(20) + nanoseconds(1)), PoseAbsence::kNotYet);
  EXPECT_EQ(absence(buffer, ms(10) - nanoseconds(1)), PoseAbsence::kTooOld);
}

TEST(PoseBufferTest, DoesNotInterpolateAcrossAnOcclusionOrAGap) {
  PoseBuffer<Probe> buffer(16, milliseconds(50));
  buffer.push(pose_at(0, 0));
  buffer.push(occluded_at(20));
  buffer.push(pose_at(40, 4));
  buffer.push(pose_at(100, 10));
  EXPECT_EQ(absence(buffer, ms(10)), PoseAbsence::kNotTracked);
  EXPECT_EQ(absence(buffer, ms(20)), PoseAbsence::kNotTracked);
  EXPECT_EQ(absence(buffer, ms(30)), PoseAbsence::kNotTracked);
  EXPECT_EQ(absence(buffer, ms(70)), PoseAbsence::kGap);
  EXPECT_TRUE(std::holds_alternative<PoseAt<Probe>>(buffer.at(ms(40))));
}

TEST(PoseBufferTest, ForgetsTheOldestPosesAndFindsEveryKeptOne) {
  PoseBuffer<Probe> buffer(8);
  for (int i = 0; i < 100; ++i) {
    buffer.push(pose_at(10 * i, i));
    const int oldest = std::max(0, i - 7);
    for (int k = oldest; k <= i; ++k) {
      const auto at = std::get<PoseAt<Probe>>(buffer.at(ms(10 * k)));
      ASSERT_EQ(at.tracker_from_body.translation_mm().x(), k);
    }
    if (oldest > 0) {
      ASSERT_EQ(absence(buffer, ms(10 * oldest - 1)), PoseAbsence::kTooOld);
    }
  }
  EXPECT_EQ(buffer.size(), 8u);
}

TEST(PoseBufferTest, APoseWithoutStatusIsDegraded) {
  PoseBuffer<Probe> buffer;
  buffer.push(pose_at(0, 0));
  buffer.push(pose_at(10, 1, TrackingStatus::kUnknown));
  EXPECT_EQ(std::get<PoseAt<Probe>>(buffer.at(ms(0))).doubt, PoseDoubt::kNone);
  EXPECT_EQ(std::get<PoseAt<Probe>>(buffer.at(ms(5))).doubt, PoseDoubt::kNoStatus);
}

TEST(PoseBufferTest, PushingAPoseThatIsNotNewerIsABug) {
  PoseBuffer<Probe> buffer;
  buffer.push(pose_at(10, 0));
  EXPECT_THROW(buffer.push(pose_at(10, 0)), Bug);
}

}  // namespace
}  // namespace nav::tracking
