// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/pose_gate.hpp"

#include <cmath>
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
  EXPECT_FALSE(gate.admit(seen_at(30, 12)).rejection);                         // 0.6 m/s.
}

TEST(PoseGateTest, ABodyThatComesBackElsewhereIsConfirmedByThreePoses) {
  PoseGate<frames::Probe> gate;
  for (int t = 0; t <= 200; t += 20) EXPECT_FALSE(gate.admit(seen_at(t)).rejection);
  EXPECT_EQ(gate.admit(seen_at(2000, 1500)).rejection, PoseRejection::kUnconfirmed);
  EXPECT_EQ(gate.admit(seen_at(2020, 1501)).rejection, PoseRejection::kUnconfirmed);
  EXPECT_FALSE(gate.admit(seen_at(2040, 1502)).rejection);
  EXPECT_FALSE(gate.admit(seen_at(2060, 1503)).rejection);
}

TEST(PoseGateTest, APoseOffThePathIsWithheldAloneAndCounted) {
  for (const int period_ms : {5, 20, 50}) {
    PoseGate<frames::Probe> gate;
    int withheld = 0;
    for (int i = 0; i < 400; ++i) {
      // A hand that sweeps to and fro by 40 mm, and two poses that are 20 mm off.
      const int t = i * period_ms;
      const double x = 40 * std::sin(t / 700.0);
      const bool wrong = i == 150 || i == 300;
      RawPose raw = seen_at(t, x + (wrong ? 20 : 0));
      raw.tracker_from_body(1, 3) = 1e-3 * i;
      const auto admission = gate.admit(raw);
      EXPECT_EQ(admission.rejection.has_value(), wrong) << period_ms << " ms, pose " << i;
      if (wrong) {
        EXPECT_EQ(to_string(*admission.rejection),
                  std::string(period_ms == 5 ? "too_fast" : "off_path"));
        EXPECT_THAT(admission.message, HasSubstr("ProbeToTracker"));
      }
      withheld += admission.rejection ? 1 : 0;
    }
    EXPECT_EQ(withheld, 2);
  }
}

TEST(PoseGateTest, ASlowStreamIsNotTakenForALostBody) {
  PoseGate<frames::Probe> gate;
  for (int i = 0; i < 40; ++i) {
    EXPECT_FALSE(gate.admit(seen_at(500 * i, 10 * std::sin(0.3 * i))).rejection) << i;
  }
}

PoseGateOptions patient() {
  PoseGateOptions options;
  options.patient = true;
  return options;
}

TEST(PoseGateTest, APatientReferenceThatWasMovedIsDegradedUntilItIsBackOrConfirmed) {
  PoseGate<frames::Reference> gate(patient());
  int t = 0;
  const auto send = [&](double x_mm) { return gate.admit(seen_at(t += 50, x_mm)); };
  // The patient breathes.
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(send(5 * std::sin(0.08 * i)).pose.doubt, PoseDoubt::kNone);
  EXPECT_TRUE(send(42).rejection);
  EXPECT_TRUE(send(42).rejection);
  const auto moved = send(42);
  EXPECT_FALSE(moved.rejection);
  EXPECT_EQ(moved.pose.doubt, PoseDoubt::kMoved);
  EXPECT_THAT(moved.message, HasSubstr("register again"));
  EXPECT_EQ(send(42).pose.doubt, PoseDoubt::kMoved);
  EXPECT_TRUE(gate.moved());
  gate.confirm_place();
  EXPECT_EQ(send(42).pose.doubt, PoseDoubt::kNone);
  // Moved again, and put back.
  for (int i = 0; i < 5; ++i) send(10);
  EXPECT_TRUE(gate.moved());
  for (int i = 0; i < 5; ++i) send(42);
  EXPECT_FALSE(gate.moved());
  EXPECT_EQ(send(42).pose.doubt, PoseDoubt::kNone);
}

TEST(PoseGateTest, APoseThatDoesNotChangeIsDegradedForAToolOnly) {
  PoseGate<frames::Probe> probe;
  PoseGate<frames::Reference> reference(patient());
  int notes = 0;
  for (int t = 0; t <= 1000; t += 50) {
    const auto admission = probe.admit(seen_at(t, 7));
    EXPECT_EQ(admission.pose.doubt, t <= 250 ? PoseDoubt::kNone : PoseDoubt::kStuck) << t;
    EXPECT_EQ(admission.message, "");
    if (admission.finding) {
      ++notes;
      EXPECT_EQ(admission.finding->subject, "ProbeToTracker");
      EXPECT_NE(admission.finding->values.at(0).find("from 0.000000 s on, for 0.300000 s or more"),
                std::string::npos)
          << admission.finding->values.at(0);
    }
    EXPECT_EQ(reference.admit(seen_at(t, 7)).pose.doubt, PoseDoubt::kNone);
  }
  EXPECT_EQ(notes, 1);
  EXPECT_EQ(probe.admit(seen_at(1050, 7.1)).pose.doubt, PoseDoubt::kNone);
}

TEST(PoseGateTest, APoseWhoseLastDigitsJitterIsStuckAndASlowMovementIsNot) {
  PoseGate<frames::Probe> jittering;
  PoseGate<frames::Probe> slow;
  std::string said;
  for (int t = 0; t <= 1000; t += 20) {
    const auto stuck = jittering.admit(seen_at(t, 7 + 1e-3 * (t / 20 % 2)));
    EXPECT_EQ(stuck.pose.doubt, t <= 250 ? PoseDoubt::kNone : PoseDoubt::kStuck) << t;
    if (stuck.finding) said += stuck.finding->values.at(0);
    // 0.1 mm in a second.
    EXPECT_EQ(slow.admit(seen_at(t, 1e-4 * t)).pose.doubt, PoseDoubt::kNone) << t;
  }
  EXPECT_THAT(said, HasSubstr("unchanged but for the last digits"));
}

TEST(PoseGateTest, APoseThatStopsInTheMiddleOfAMovementIsDegradedAtOnce) {
  PoseGate<frames::Probe> gate;
  // 100 mm/s, which is 2 mm in each sample.
  for (int t = 0; t <= 1000; t += 20) {
    EXPECT_EQ(gate.admit(seen_at(t, 0.1 * t)).pose.doubt, PoseDoubt::kNone) << t;
  }
  const auto first = gate.admit(seen_at(1020, 100));
  EXPECT_EQ(first.pose.doubt, PoseDoubt::kStuck);
  ASSERT_TRUE(first.finding);
  EXPECT_THAT(first.finding->values.at(0), HasSubstr("unchanged to the last digit"));
  EXPECT_EQ(gate.admit(seen_at(1040, 100.1)).pose.doubt, PoseDoubt::kNone);
  // An arm whose encoders count slowly: 5 mm/s in steps of 0.1 mm, read every 4 ms.
  PoseGate<frames::Probe> arm;
  for (int t = 0; t <= 2000; t += 4) {
    EXPECT_EQ(arm.admit(seen_at(t, 0.1 * (t / 20))).pose.doubt, PoseDoubt::kNone) << t;
  }
}

TEST(PoseGateTest, AShortExcursionIsNeverAdopted) {
  for (const double off_mm : {20.0, 60.0}) {
    PoseGate<frames::Probe> gate;
    for (int t = 0; t <= 2000; t += 50) {
      const bool away = t > 1000 && t <= 1300;
      const auto admission = gate.admit(seen_at(t, 0.01 * t + (away ? off_mm : 0)));
      EXPECT_EQ(admission.rejection.has_value(), away) << off_mm << " mm at " << t << " ms";
    }
  }
}

TEST(PoseGateTest, TheIdentityInPlaceOfAHiddenToolIsNeverAdopted) {
  PoseGate<frames::Probe> gate;
  for (int t = 0; t <= 4000; t += 50) {
    RawPose pose = seen_at(t, 30 + 0.01 * t);
    const bool hidden = t > 1000 && t <= 3000;
    if (hidden) pose.tracker_from_body.setIdentity();
    const auto admission = gate.admit(pose);
    // It is back after three poses that agree.
    const bool returning = t > 3000 && t <= 3200;
    if (!returning) {
      EXPECT_EQ(admission.rejection.has_value(), hidden) << t;
    }
  }
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

TEST(PoseGateTest, AClockThatWasSetIsFoundAtOnceAndFollowedAsDegraded) {
  for (const int step_ms : {-500, -70, 70, 90}) {
    PoseGate<frames::Probe> gate;
    for (int t = 0; t < 1000; t += 20) {
      RawPose raw = seen_at(t, 0.01 * t);
      raw.received += milliseconds(15);
      EXPECT_FALSE(gate.admit(raw).rejection);
    }
    int rejected = 0;
    for (int t = 1000; t < 3000; t += 20) {
      RawPose raw = seen_at(t + step_ms, 0.01 * t);
      raw.received = Timestamp(milliseconds(t + 15));
      const auto admission = gate.admit(raw);
      rejected += admission.rejection ? 1 : 0;
      if (t < 1300) {
        ASSERT_TRUE(admission.rejection) << step_ms << " ms at " << t;
        EXPECT_FALSE(has_usable_time(admission.rejection));
      }
      if (t > 2100) {
        ASSERT_FALSE(admission.rejection) << step_ms << " ms at " << t << admission.message;
        EXPECT_EQ(admission.pose.doubt, PoseDoubt::kClock);
      }
    }
    EXPECT_LE(rejected, 55);
  }
}

TEST(PoseGateTest, ADriftingClockAndALongerDelayAreFollowed) {
  // An hour at 50 Hz by a clock that is 50 ppm slow, and a link that becomes 80 ms slower after 40
  // minutes.
  PoseGate<frames::Probe> gate;
  int rejected = 0;
  for (int i = 0; i < 180000; ++i) {
    const double t = 0.02 * i;
    RawPose raw = seen_at(0, 20 * std::sin(t));
    raw.acquired = Timestamp(from_seconds(t * (1 - 50e-6)));
    raw.received = Timestamp(from_seconds(t + (t > 2400 ? 0.095 : 0.015)));
    rejected += gate.admit(raw).rejection ? 1 : 0;
  }
  EXPECT_LE(rejected, 50);
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
    EXPECT_TRUE(gate.admit(flipped).rejection) << t;
  }
  EXPECT_FALSE(gate.admit(seen_at(1000)).rejection);
}

TEST(PoseGateTest, RejectsInvalidLimits) {
  PoseGateOptions options;
  options.working_radius_mm = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(validate(options));
  EXPECT_THROW(PoseGate<frames::Probe>{options}, Bug);
  options = {};
  options.max_turn_rad_per_s = 0;
  EXPECT_FALSE(validate(options));
  options = {};
  options.max_delay_change = Duration(0);
  EXPECT_FALSE(validate(options));
}

}  // namespace
}  // namespace nav::tracking
