// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include "nav/transform.hpp"
#include "sim/random.hpp"
#include "sim/trackers/electromagnetic_tracker.hpp"
#include "sim/trackers/encoder_arm.hpp"
#include "sim/trackers/optical_tracker.hpp"
#include "sim/trackers/sensor_pose_source.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using std::chrono::milliseconds;

Eigen::Matrix4d pose_of(const Vec& turn, const Vec& mm) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  if (turn.norm() > 0) {
    m.topLeftCorner<3, 3>() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  }
  m.topRightCorner<3, 1>() = mm;
  return m;
}
Vec position(const Observation& o) { return o.pose.topRightCorner<3, 1>(); }

OpticalTrackerOptions unbiased() {
  OpticalTrackerOptions options;
  options.bias_mm = 0;
  return options;
}

TEST(OpticalTrackerTest, NoiseFollowsTriangulation) {
  OpticalTrackerOptions options = unbiased();
  // The origin of the body is the mean of its four markers, so its noise is the noise of a marker
  // divided by √4.
  options.markers = {{{50, 50, 0}}, {{-50, 50, 0}}, {{-50, -50, 0}}, {{50, -50, 0}}};
  const OpticalTracker tracker(options);
  const Vec at(30, -20, 1500);
  Vec square = Vec::Zero();
  constexpr int kSamples = 4000;
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const auto seen = tracker.observe(pose_of(Vec::Zero(), at), 0, i);
    ASSERT_EQ(seen.status, TrackingStatus::kOk);
    square += (position(seen) - at).cwiseAbs2();
  }
  const Vec sigma = (square / kSamples).cwiseSqrt();
  const Eigen::Vector2d expected = tracker.marker_sigma_mm(1500) / 2;
  EXPECT_NEAR(sigma.x() / expected[0], 1, 0.05);
  EXPECT_NEAR(sigma.y() / expected[0], 1, 0.05);
  EXPECT_NEAR(sigma.z() / expected[1], 1, 0.05);
  EXPECT_NEAR(expected[1] / expected[0], 2 * 1500.0 / 500, 1e-9);  // The noise along the viewing
                                                                   // direction is larger.
}

TEST(OpticalTrackerTest, WithoutNoiseThePoseIsExact) {
  OpticalTrackerOptions options = unbiased();
  options.centroid_px = 0;
  const OpticalTracker tracker(options);
  const auto truth = pose_of({0.4, -0.3, 1.2}, {100, 50, 1800});
  EXPECT_LE((tracker.observe(truth, 0, 0).pose - truth).norm(), 1e-9);
}

TEST(OpticalTrackerTest, BiasIsSmoothConstantAndOfItsSize) {
  OpticalTrackerOptions options;
  options.centroid_px = 0;
  options.bias_mm = 0.2;
  double square = 0;
  constexpr int kSeeds = 300;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    options.seed = seed;
    const OpticalTracker tracker(options);
    const auto truth = pose_of(Vec::Zero(), {0, 0, 1500});
    const auto near = pose_of(Vec::Zero(), {1, 0, 1500});
    const Vec error = position(tracker.observe(truth, 0, 0)) - Vec(0, 0, 1500);
    const Vec beside = position(tracker.observe(near, 0, 9)) - Vec(1, 0, 1500);
    EXPECT_LE((error - beside).norm(), 0.02);
    square += error.squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(square / kSeeds), 0.2, 0.03);
}

TEST(OpticalTrackerTest, LosesMarkersThatAreHiddenTurnedAwayOrOutside) {
  OpticalTrackerOptions options = unbiased();
  options.obstacles = {{{0, 0, 1000}, 60}};
  const OpticalTracker hidden(options);
  EXPECT_EQ(hidden.observe(pose_of(Vec::Zero(), {0, 0, 1050}), 0, 0).status,
            TrackingStatus::kOccluded);
  EXPECT_EQ(hidden.observe(pose_of(Vec::Zero(), {0, 0, 980 - 500}), 0, 0).status,
            TrackingStatus::kOutOfVolume);
  options = unbiased();
  options.check_incidence = true;
  const OpticalTracker facing(options);
  EXPECT_EQ(facing.observe(pose_of({M_PI, 0, 0}, {0, 0, 1500}), 0, 0).status, TrackingStatus::kOk);
  const auto away = facing.observe(pose_of(Vec::Zero(), {0, 0, 1500}), 0, 0);
  EXPECT_EQ(away.status, TrackingStatus::kOccluded);
  EXPECT_TRUE(away.pose.array().isNaN().all());
}

TEST(OpticalTrackerTest, RejectsMarkersOnALine) {
  OpticalTrackerOptions options;
  options.markers = {{{0, 0, 0}}, {{50, 0, 0}}, {{120, 0, 0}}};
  EXPECT_FALSE(validate(options));
}

TEST(ElectromagneticTrackerTest, JacobianOfTheDistortionIsItsDerivative) {
  const ElectromagneticTracker tracker({});
  Random random(5, 5);
  for (int i = 0; i < 100; ++i) {
    const Vec p = Vec(0, 0, 300) + random.offset(240);
    const auto j = tracker.distortion_jacobian(p);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec step = 0.01 * Vec::Unit(axis);
      const Vec slope = (tracker.distortion_mm(p + step) - tracker.distortion_mm(p - step)) / 0.02;
      EXPECT_LE((slope - j.col(axis)).norm(), 1e-9);
    }
    EXPECT_LT(j.norm(), 0.5);
  }
}

TEST(ElectromagneticTrackerTest, MeasuresTruthPlusDistortionOnAverage) {
  const ElectromagneticTracker tracker({});
  const auto truth = pose_of({0.2, 0.5, -0.3}, {120, -60, 280});
  const Vec p = truth.topRightCorner<3, 1>();
  Vec sum = Vec::Zero();
  constexpr int kSamples = 2000;
  for (std::uint64_t i = 0; i < kSamples; ++i) sum += position(tracker.observe(truth, 1, i)) - p;
  const double sigma = 0.12 * tracker.noise_growth(p.norm());
  EXPECT_LE((sum / kSamples - tracker.distortion_mm(p)).norm(), 4 * sigma / std::sqrt(kSamples));
}

TEST(ElectromagneticTrackerTest, NoiseGrowsWithTheFourthPowerOfTheDistanceUpToTheVolumeLimit) {
  const ElectromagneticTracker tracker({});
  EXPECT_EQ(tracker.noise_growth(200), 1);
  EXPECT_NEAR(tracker.noise_growth(600), 16, 1e-12);
  EXPECT_EQ(tracker.observe(pose_of(Vec::Zero(), {0, 0, 600}), 0, 0).status,
            TrackingStatus::kOutOfVolume);
  EXPECT_EQ(tracker.observe(pose_of(Vec::Zero(), {260, 0, 300}), 0, 0).status,
            TrackingStatus::kOutOfVolume);
}

TEST(EncoderArmTest, InverseKinematicsInvertsForwardKinematics) {
  const EncoderArm arm({});
  Random random(11, 1);
  for (int i = 0; i < 500; ++i) {
    JointAngles q;
    for (double& angle : q) angle = random.uniform(-3, 3);
    const auto pose = arm.forward(q);
    const auto found = arm.inverse(pose);
    ASSERT_TRUE(found);
    EXPECT_LE((arm.forward(*found) - pose).norm(), 1e-7);
  }
}

TEST(EncoderArmTest, InverseHandlesStraightWristsAndStraightArms) {
  const EncoderArm arm({});
  for (const double wrist : {0.0, 1e-12, 1e-9, 1e-6, M_PI, -1e-12}) {
    for (const double elbow : {0.3, 1e-6, 2.9}) {
      const JointAngles q{0.4, -0.2, elbow, 0.7, wrist, -0.5};
      const auto pose = arm.forward(q);
      const auto found = arm.inverse(pose);
      ASSERT_TRUE(found) << wrist << ' ' << elbow;
      EXPECT_LE((arm.forward(*found) - pose).norm(), 1e-5) << wrist << ' ' << elbow;
    }
  }
}

TEST(EncoderArmTest, ErrorStaysWithinTheEncoderResolution) {
  EncoderArmOptions options;
  options.noise_counts = 0;
  options.offset_rad = 0;
  options.length_error_mm = 0;
  const EncoderArm arm(options);
  Random random(3, 1);
  double worst = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const auto truth = pose_of(random.offset(1), Vec(450, 0, 250) + random.offset(150));
    const auto seen = arm.observe(truth, 0, i);
    ASSERT_EQ(seen.status, TrackingStatus::kOk);
    worst = std::max(worst, (seen.pose - truth).topRightCorner<3, 1>().norm());
  }
  // Half a count at each of six joints, over at most the whole reach.
  const double bound = 6 * 0.5 * arm.resolution_rad() * (550 + 500 + 80);
  EXPECT_LE(worst, bound);
  EXPECT_GT(worst, 0.05 * bound);
  EXPECT_EQ(arm.observe(pose_of(Vec::Zero(), {3000, 0, 0}), 0, 0).status,
            TrackingStatus::kOutOfVolume);
}

SensorStream stream_of(const TrackerTiming& timing) {
  SensorStream stream;
  stream.truth = [](Timestamp t) { return pose_of(Vec::Zero(), {10 * to_seconds(t), 0, 300}); };
  stream.sensor = std::make_shared<ElectromagneticTracker>(ElectromagneticTrackerOptions{});
  stream.timing = timing;
  stream.begin = Timestamp(milliseconds(1000));
  stream.end = Timestamp(milliseconds(11000));
  return stream;
}

std::vector<RawPose> all(SensorPoseSource source) {
  std::vector<RawPose> poses;
  while (auto pose = source.next(Timestamp::max())) poses.push_back(*pose);
  return poses;
}

TEST(SensorPoseSourceTest, TimestampsHaveTheStatedOffsetDriftLatencyAndJitter) {
  TrackerTiming timing;
  timing.clock_offset = milliseconds(3);
  timing.drift_ppm = 500;
  const auto poses = all(SensorPoseSource(stream_of(timing)));
  ASSERT_EQ(poses.size(), 501u);
  EXPECT_EQ(poses.front().acquired, Timestamp(milliseconds(1003)));
  // 10 s at 500 parts per million: 5 ms.
  EXPECT_NEAR(to_seconds(poses.back().acquired - Timestamp(milliseconds(11003))), 5e-3, 1e-9);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Timestamp measured = Timestamp(milliseconds(1000 + 20 * static_cast<int>(i)));
    EXPECT_GE(poses[i].received - measured, milliseconds(15));
    EXPECT_LE(poses[i].received - measured, milliseconds(17));
  }
}

TEST(SensorPoseSourceTest, DeliversInOrderOfArrivalAndNeverEarly) {
  TrackerTiming timing;
  timing.jitter = milliseconds(60);  // Longer than the period: poses overtake each other.
  SensorPoseSource source(stream_of(timing));
  int overtaken = 0, timeouts = 0;
  Timestamp last_acquired{}, last_received{};
  for (Timestamp now{}; source.next_arrival() != Timestamp::max(); now += milliseconds(7)) {
    for (;;) {
      const auto pose = source.next(now);
      if (!pose) {
        timeouts += pose.error().code == ErrorCode::kTimeout ? 1 : 0;
        break;
      }
      EXPECT_LE(pose->received, now);
      EXPECT_GE(pose->received, last_received);
      overtaken += pose->acquired < last_acquired ? 1 : 0;
      last_acquired = pose->acquired;
      last_received = pose->received;
    }
  }
  EXPECT_GT(timeouts, 10);
  EXPECT_GT(overtaken, 0);
  EXPECT_EQ(source.next(Timestamp::max()).error().code, ErrorCode::kEndOfStream);
}

TEST(SensorPoseSourceTest, LossesComeInBurstsOfTheStatedLength) {
  TrackerTiming timing;
  timing.rate_hz = 1000;
  timing.loss_begins = 0.02;
  timing.loss_ends = 0.1;
  const auto poses = all(SensorPoseSource(stream_of(timing)));
  int lost = 0, bursts = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const bool now = poses[i].status != TrackingStatus::kOk;
    lost += now ? 1 : 0;
    if (now && (i == 0 || poses[i - 1].status == TrackingStatus::kOk)) ++bursts;
    if (now) {
      EXPECT_TRUE(poses[i].tracker_from_body.array().isNaN().all());
    }
  }
  EXPECT_NEAR(static_cast<double>(lost) / bursts, 10, 2.5);
  EXPECT_NEAR(lost / 10001.0, 0.02 / 0.12, 0.04);
}

TEST(SensorPoseSourceTest, IsDeterministicAndRespectsDeadlines) {
  TrackerTiming timing;
  timing.loss_begins = 0.01;
  const auto a = all(SensorPoseSource(stream_of(timing)));
  const auto b = all(SensorPoseSource(stream_of(timing)));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].received, b[i].received);
    EXPECT_EQ(a[i].status, b[i].status);
    if (a[i].status == TrackingStatus::kOk) {
      EXPECT_EQ(a[i].tracker_from_body, b[i].tracker_from_body);
    }
  }
  SensorPoseSource source(stream_of(timing));
  EXPECT_EQ(source.next(Timestamp(milliseconds(1014))).error().code, ErrorCode::kTimeout);
  EXPECT_TRUE(source.next(Timestamp(milliseconds(1018))));
  source.stop();
  EXPECT_EQ(source.next(Timestamp::max()).error().code, ErrorCode::kCancelled);
}

TEST(SensorPoseSourceTest, RejectsInvalidTimings) {
  TrackerTiming timing;
  timing.rate_hz = 0;
  EXPECT_FALSE(validate(timing));
  timing = {};
  timing.loss_ends = 0;
  EXPECT_FALSE(validate(timing));
  timing = {};
  timing.drift_ppm = std::nan("");
  EXPECT_FALSE(validate(timing));
}

}  // namespace
}  // namespace nav::sim
