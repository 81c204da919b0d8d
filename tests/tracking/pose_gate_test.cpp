// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/pose_gate.hpp"

#include <gmock/gmock.h>
#include <limits>

namespace nav::tracking {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

RawPose seen_at(int ms, double x_mm = 0) {
  RawPose raw;
  raw.acquired = Timestamp(milliseconds(ms));
  raw.received = raw.acquired;
  raw.status = TrackingStatus::kOk;
  raw.tracker_from_body = Eigen::Matrix4d::Identity();
  raw.tracker_from_body(0, 3) = x_mm;
  return raw;
}

TEST(PoseGateTest, AdmitsARigidPose) {
  PoseGate<frames::Probe> gate;
  const auto admission = gate.admit(seen_at(10, 5));
  EXPECT_FALSE(admission.rejection);
  ASSERT_TRUE(admission.pose.tracker_from_body);
  EXPECT_EQ(admission.pose.tracker_from_body->translation_mm().x(), 5);
}

TEST(PoseGateTest, NeverTurnsAnAbsentPoseIntoIdentity) {
  PoseGate<frames::Probe> gate;
  RawPose raw = seen_at(10);
  raw.status = TrackingStatus::kOccluded;  // Drivers send the identity or the last pose together
                                           // with this status.
  const auto admission = gate.admit(raw);
  EXPECT_EQ(admission.rejection, PoseRejection::kStatus);
  EXPECT_FALSE(admission.pose.tracker_from_body);
  EXPECT_EQ(admission.pose.status, TrackingStatus::kOccluded);
}

TEST(PoseGateTest, RejectsNanReflectionAndScale) {
  PoseGate<frames::Probe> gate;
  RawPose raw = seen_at(1);
  raw.tracker_from_body(2, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(gate.admit(raw).rejection, PoseRejection::kNotRigid);
  raw = seen_at(2);
  raw.tracker_from_body(2, 2) = -1;
  auto admission = gate.admit(raw);
  EXPECT_EQ(admission.rejection, PoseRejection::kNotRigid);
  EXPECT_THAT(admission.message, HasSubstr("reflection"));
  EXPECT_THAT(admission.message, HasSubstr("ProbeToTracker"));
  EXPECT_EQ(admission.pose.status, TrackingStatus::kInvalid);
  raw = seen_at(3);
  raw.tracker_from_body.topLeftCorner<3, 3>() *= 1.01;
  EXPECT_EQ(gate.admit(raw).rejection, PoseRejection::kNotRigid);
}

TEST(PoseGateTest, RejectsPosesOutsideTheWorkingVolumeAndJumps) {
  PoseGateOptions options;
  options.working_radius_mm = 3000;
  PoseGate<frames::Probe> gate(options);
  EXPECT_EQ(gate.admit(seen_at(1, 3001)).rejection, PoseRejection::kOutsideVolume);
  EXPECT_FALSE(gate.admit(seen_at(10, 0)).rejection);
  EXPECT_EQ(gate.admit(seen_at(20, 100)).rejection, PoseRejection::kTooFast);  // 10 m/s.
  EXPECT_FALSE(gate.admit(seen_at(30, 20)).rejection);                         // 1 m/s.
  EXPECT_FALSE(gate.admit(seen_at(2000, 2000)).rejection);  // After a pause without poses, the gate
                                                            // accepts any position.
}

TEST(PoseGateTest, RejectsDuplicateBackwardsAndFutureTimes) {
  PoseGate<frames::Probe> gate;
  EXPECT_FALSE(gate.admit(seen_at(10)).rejection);
  EXPECT_EQ(gate.admit(seen_at(10)).rejection, PoseRejection::kTime);
  EXPECT_EQ(gate.admit(seen_at(9)).rejection, PoseRejection::kTime);
  RawPose future = seen_at(1000000);
  future.received = Timestamp(milliseconds(20));
  EXPECT_EQ(gate.admit(future).rejection, PoseRejection::kTime);
  EXPECT_FALSE(gate.admit(seen_at(20)).rejection) << "one absurd stamp must not shut the gate";
}

TEST(PoseGateTest, RejectsPosesAfterAClockChangeUntilItIsUndone) {
  for (const int step_ms : {-500, -70, 70, 90}) {
    PoseGate<frames::Probe> gate;
    for (int t = 0; t < 1000; t += 20) {
      RawPose raw = seen_at(t);
      raw.received += milliseconds(15);
      EXPECT_FALSE(gate.admit(raw).rejection);
    }
    for (int t = 1000; t < 3000; t += 20) {
      RawPose raw = seen_at(t + step_ms);
      raw.received = Timestamp(milliseconds(t + 15));
      const auto rejection = gate.admit(raw).rejection;
      ASSERT_TRUE(rejection) << step_ms << " ms at " << t;
      EXPECT_FALSE(has_usable_time(rejection));
    }
    int refused = 0;
    for (int t = 3000; t < 3500; t += 20) {
      RawPose again = seen_at(t);
      again.received += milliseconds(15);
      refused += gate.admit(again).rejection ? 1 : 0;
    }
    // The gate accepts poses again at once, or after 100 ms if the data looked delayed, and in
    // every case only after the latest future timestamp has passed.
    EXPECT_LE(refused, 6) << "set back, it is believed again";
  }
}

TEST(PoseGateTest, OneLateFirstPoseDoesNotSetTheUsualDelay) {
  for (const int first_ms : {315, -90}) {
    PoseGate<frames::Probe> gate;
    RawPose raw = seen_at(0);
    raw.received = Timestamp(milliseconds(first_ms));
    gate.admit(raw);
    int refused = 0;
    for (int t = 20; t < 1000; t += 20) {
      raw = seen_at(t);
      raw.received += milliseconds(15);
      refused += gate.admit(raw).rejection ? 1 : 0;
    }
    EXPECT_LE(refused, 7) << first_ms;
  }
}

TEST(PoseGateTest, RejectsPosesThatAreDelayedAndShiftedInTimeAtOnce) {
  PoseGate<frames::Probe> gate;
  const auto send = [&gate](int acquired_ms, int received_ms) {
    RawPose raw = seen_at(acquired_ms);
    raw.received = Timestamp(milliseconds(received_ms));
    return !gate.admit(raw).rejection;
  };
  for (int t = 0; t < 1000; t += 20) EXPECT_TRUE(send(t, t + 15));
  // The clock is 150 ms ahead, and all samples up to 1300 ms arrive at 1315 ms. The timestamp of
  // the eighth sample therefore has the usual age.
  for (int t = 1000; t < 1300; t += 20) EXPECT_FALSE(send(t + 150, 1315)) << t;
  EXPECT_FALSE(send(1500, 1515));
  EXPECT_TRUE(send(1640, 1655));
}

TEST(PoseGateTest, RejectsAHalfTurnThatIsFasterThanAHand) {
  PoseGate<frames::Probe> gate;
  EXPECT_FALSE(gate.admit(seen_at(0)).rejection);
  for (int t = 20; t < 1000; t += 20) {
    RawPose flipped = seen_at(t);
    flipped.tracker_from_body(0, 0) = flipped.tracker_from_body(1, 1) = -1;
    EXPECT_EQ(gate.admit(flipped).rejection, PoseRejection::kTooFast);
  }
  EXPECT_FALSE(gate.admit(seen_at(1000)).rejection);
}

TEST(PoseGateTest, RejectsInvalidLimits) {
  PoseGateOptions options;
  options.working_radius_mm = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(validate(options));
  EXPECT_THROW(PoseGate<frames::Probe>{options}, Bug);
  options = {};
  options.max_turn_rad = 0;
  EXPECT_FALSE(validate(options));
  options = {};
  options.max_delay_change = Duration(0);
  EXPECT_FALSE(validate(options));
}

}  // namespace
}  // namespace nav::tracking
