// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/simulated_tracker.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav::sim {
namespace {

using namespace std::chrono_literals;

ProcedureOptions short_procedure() {
  ProcedureOptions options;
  options.seed = 3;
  options.sweep_frames = 4;
  options.approach_frames = 3;
  return options;
}

std::vector<RawPose> drain(SimulatedTracker& source) {
  std::vector<RawPose> poses;
  while (auto pose = source.next(Timestamp::max())) poses.push_back(*pose);
  return poses;
}

TEST(SimulatedTrackerTest, DeliversInOrderOfArrivalAndNeverEarly) {
  ProcedureOptions options = short_procedure();
  options.tracker.jitter = 60ms;  // The jitter is longer than the period, so poses overtake each
                                  // other.
  const Procedure procedure(options);
  SimulatedTracker source(procedure, TrackedBody::kProbe);
  int overtaken = 0;
  int timeouts = 0;
  Timestamp last_acquired{};
  Timestamp last_received{};
  for (Timestamp now{}; source.next_arrival() != Timestamp::max(); now += 7ms) {
    while (true) {
      const auto pose = source.next(now);
      if (!pose) {
        if (pose.error().code == ErrorCode::kTimeout) ++timeouts;
        break;
      }
      EXPECT_LE(pose->received, now);
      EXPECT_GE(pose->received, last_received);
      EXPECT_GE(pose->received - pose->acquired, options.tracker.latency);
      EXPECT_LE(pose->received - pose->acquired, options.tracker.latency + 60ms + Duration(1));
      overtaken += pose->acquired < last_acquired ? 1 : 0;
      last_acquired = pose->acquired;
      last_received = pose->received;
    }
  }
  EXPECT_GT(timeouts, 10);
  EXPECT_GT(overtaken, 0);
  EXPECT_TRUE(test::rejects(source.next(Timestamp::max()), ErrorCode::kEndOfStream, {"tracker"}));
}

TEST(SimulatedTrackerTest, NoiseHasTheStatedStandardDeviation) {
  ProcedureOptions options = short_procedure();
  options.tracker.rate_hz = 1000;
  options.tracker.noise_mm = 0.2;
  options.tracker.noise_rad = 0.002;
  const Procedure procedure(options);
  SimulatedTracker source(procedure, TrackedBody::kProbe);
  const auto poses = drain(source);
  double shift = 0;
  double turn = 0;
  for (const RawPose& raw : poses) {
    const auto pose = rigid_from_matrix<frames::Tracker, frames::Probe>(raw.tracker_from_body);
    ASSERT_TRUE(test::has_value(pose));
    const auto truth = procedure.tracker_from_probe(raw.acquired);
    shift += (pose->translation_mm() - truth.translation_mm()).squaredNorm() / 3;
    turn += std::pow(rotation_distance_rad(*pose, truth), 2) / 3;
  }
  const auto n = static_cast<double>(poses.size());
  ASSERT_GT(n, 2000);
  // Five standard errors of a standard deviation that is estimated from 3 n numbers.
  const double relative = 5 / std::sqrt(6 * n);
  EXPECT_NEAR(std::sqrt(shift / n), 0.2, 0.2 * relative);
  EXPECT_NEAR(std::sqrt(turn / n), 0.002, 0.002 * relative);
}

TEST(SimulatedTrackerTest, OcclusionsHaveAStatusAndNanButNeverIdentity) {
  ProcedureOptions options = short_procedure();
  options.tracker.dropout_probability = 0.05;
  options.tracker.dropout_samples = 4;
  const Procedure procedure(options);
  SimulatedTracker source(procedure, TrackedBody::kNeedle);
  int occluded = 0;
  int run = 0;
  for (const RawPose& pose : drain(source)) {
    if (pose.status == TrackingStatus::kOk) {
      EXPECT_TRUE(pose.tracker_from_body.allFinite());
      EXPECT_TRUE(run == 0 || run >= 4) << run;
      run = 0;
      continue;
    }
    EXPECT_EQ(pose.status, TrackingStatus::kOccluded);
    EXPECT_TRUE(pose.tracker_from_body.array().isNaN().all());
    ++occluded;
    ++run;
  }
  EXPECT_GT(occluded, 8);
}

TEST(SimulatedTrackerTest, BodiesHaveIndependentNoise) {
  const Procedure procedure(short_procedure());
  SimulatedTracker reference(procedure, TrackedBody::kReference);
  SimulatedTracker probe(procedure, TrackedBody::kProbe);
  const auto a = drain(reference);
  const auto b = drain(probe);
  ASSERT_EQ(a.size(), b.size());
  const auto shift = [](const RawPose& raw, const Eigen::Matrix4d& truth) {
    return Eigen::Vector3d((raw.tracker_from_body - truth).topRightCorner<3, 1>());
  };
  int equal = 0;
  for (const RawPose& pa : a) {
    for (const RawPose& pb : b) {
      if (pa.acquired != pb.acquired) continue;
      const auto na = shift(pa, procedure.tracker_from_reference(pa.acquired).matrix());
      const auto nb = shift(pb, procedure.tracker_from_probe(pb.acquired).matrix());
      equal += (na - nb).norm() < 1e-6 ? 1 : 0;
    }
  }
  EXPECT_EQ(equal, 0);
}

TEST(SimulatedProbeTest, DelaysTimestampsAndDeliveryLikeADevice) {
  ProcedureOptions options = short_procedure();
  options.image_timing.stamp_offset = 40ms;
  options.image_timing.latency = 70ms;
  const Procedure procedure(options);
  SimulatedProbe source(procedure);
  EXPECT_TRUE(test::rejects(source.next(procedure.frame_time(0) + 70ms - Duration(1)),
                            ErrorCode::kTimeout, {"probe"}));
  for (int i = 0; i < procedure.frame_count(); ++i) {
    const auto frame = source.next(procedure.frame_time(i) + 70ms);
    ASSERT_TRUE(test::has_value(frame));
    EXPECT_EQ(frame->sequence, static_cast<std::uint64_t>(i));
    EXPECT_EQ(frame->acquired, procedure.frame_time(i) + 40ms);
    EXPECT_EQ(frame->received, procedure.frame_time(i) + 70ms);
    if (i == 2) {
      // The image shows the state at the physical time, not at the timestamp.
      const auto truth = source.simulator().simulate(
          procedure.ct_from_image(procedure.frame_time(i)), Timestamp{}, 2);
      EXPECT_TRUE(std::ranges::equal(truth.pixels.pixels(), frame->pixels.pixels()));
    }
  }
  EXPECT_TRUE(test::rejects(source.next(Timestamp::max()), ErrorCode::kEndOfStream, {"probe"}));
  source.stop();
  source.stop();
  EXPECT_TRUE(test::rejects(source.next(Timestamp::max()), ErrorCode::kCancelled, {"stopped"}));
}

}  // namespace
}  // namespace nav::sim
