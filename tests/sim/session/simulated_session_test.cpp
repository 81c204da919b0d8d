// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/session/simulated_session.hpp"

#include <gmock/gmock.h>

#include "sim/session/simulated_devices.hpp"
#include "sim/simulated_source.hpp"
#include "tests/support/matchers.hpp"

namespace nav::sim {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using Vec = Eigen::Vector3d;

constexpr double kRoundingMm = 1e-9;
constexpr double kRoundingRad = 1e-7;

SimulatedSessionOptions small() {
  SimulatedSessionOptions options;
  options.probe.columns = 80;
  options.probe.rows = 60;
  options.probe.lines = 32;
  options.duration_s = 1;
  options.frame_rate_hz = 5;
  options.tracker = TrackerKind::kIdeal;
  return options;
}

SimulatedSession make(const SimulatedSessionOptions& options) {
  auto session = SimulatedSession::create(options);
  EXPECT_TRUE(session.has_value()) << session.error().message;
  return std::move(*session);
}

TEST(RestViewTest, InvertsARigidMotionAndReportsTheRemainingDeformation) {
  const PixelGrid grid = PixelGrid::centred(100, 1, 1);
  const Transform<frames::Ct, frames::Image> pose(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Vec(1, 2, 3).normalized())), {-80, -70, 10});
  const auto warp = AffineWarp::rigid({0.05, -0.02, 0.1}, {-60, 0, 0}, {1, -4, -12});
  const auto view = rest_view(warp, pose, grid, 100, 80);
  EXPECT_LE(view.deformation_rms_mm, 1e-9);
  for (const Vec& p : {Vec(0, 0, 0), Vec(30, 70, 0), Vec(5, 5, 20)}) {
    EXPECT_LE((warp.apply((view.ct_from_image * Point<frames::Image>{p}).mm) -
               (pose * Point<frames::Image>{p}).mm)
                  .norm(),
              1e-9);
  }
  Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
  stretch(1, 1) = 0.9;
  const auto squeezed = rest_view(AffineWarp(stretch, Vec::Zero()), pose, grid, 100, 80);
  EXPECT_GT(squeezed.deformation_rms_mm, 1);
}

TEST(SimulatedSessionTest, TheTransformChainOfAnIdealTrackerGivesTheTruth) {
  const auto session = make(small());
  auto probe = session.probe_poses();
  auto reference = session.reference_poses();
  const auto raw_probe = probe->next(Timestamp::max());
  const auto raw_reference = reference->next(Timestamp::max());
  ASSERT_TRUE(raw_probe && raw_reference);
  const auto tracker_from_probe =
      rigid_from_matrix<frames::Tracker, frames::Probe>(raw_probe->tracker_from_body);
  const auto tracker_from_reference =
      rigid_from_matrix<frames::Tracker, frames::Reference>(raw_reference->tracker_from_body);
  ASSERT_TRUE(tracker_from_probe && tracker_from_reference);
  // Before the first image, the hand rests but trembles. Therefore the truth is taken at the time
  // of the pose.
  const auto expected = session.tracker_from_probe(raw_probe->acquired);
  EXPECT_TRUE(test::is_near(*tracker_from_probe, expected, kRoundingMm, kRoundingRad));
  const ImageTruth truth = session.truth(3);
  const auto chain = session.ct_from_reference() * session.tracker_from_reference().inverse() *
                     session.tracker_from_probe(truth.physical) * session.probe_from_image();
  EXPECT_TRUE(test::is_near(chain, truth.ct_from_image, 1e-8, kRoundingRad));
}

TEST(SimulatedSessionTest, EveryTrackerTracksBothBodies) {
  for (const auto kind :
       {TrackerKind::kOptical, TrackerKind::kElectromagnetic, TrackerKind::kArm}) {
    SimulatedSessionOptions options = small();
    options.tracker = kind;
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      options.seed = seed;
      const auto session = make(options);
      auto probe = session.probe_poses();
      double worst = 0;
      while (const auto pose = probe->next(Timestamp::max())) {
        ASSERT_EQ(pose->status, TrackingStatus::kOk) << to_string(kind) << ' ' << seed;
        const Vec truth = session.tracker_from_probe(pose->acquired).translation_mm();
        worst =
            std::max(worst, (Vec(pose->tracker_from_body.topRightCorner<3, 1>()) - truth).norm());
      }
      EXPECT_GT(worst, 0.01) << to_string(kind);
      EXPECT_LT(worst, 4) << to_string(kind);
      auto reference = session.reference_poses();
      EXPECT_EQ(reference->next(Timestamp::max())->status, TrackingStatus::kOk);
    }
  }
}

TEST(SimulatedSessionTest, BodiesHaveIndependentNoise) {
  SimulatedSessionOptions options = small();
  options.tracker = TrackerKind::kOptical;
  const auto session = make(options);
  const auto probe = session.probe_poses();
  const auto reference = session.reference_poses();
  const auto turn = [](const Eigen::Matrix4d& measured, const Eigen::Matrix4d& truth) {
    return Eigen::Matrix3d((truth.transpose() * measured).topLeftCorner<3, 3>());
  };
  int count = 0;
  for (;;) {
    const auto a = probe->next(Timestamp::max());
    const auto b = reference->next(Timestamp::max());
    if (!a || !b) break;
    ASSERT_TRUE(a->tracker_from_body.allFinite() && b->tracker_from_body.allFinite());
    EXPECT_GT((turn(a->tracker_from_body, session.tracker_from_probe(a->acquired).matrix()) -
               turn(b->tracker_from_body, session.tracker_from_reference().matrix()))
                  .norm(),
              1e-6);
    ++count;
  }
  EXPECT_GT(count, 90);
}

TEST(SimulatedSessionTest, DelaysTimestampsAndDeliveryLikeADevice) {
  SimulatedSessionOptions options = small();
  options.image_timing = {milliseconds(40), milliseconds(70)};
  const auto session = make(options);
  const auto source = session.frames();
  EXPECT_TRUE(test::rejects(source->next(session.frame_time(0) + milliseconds(70) - Duration(1)),
                            ErrorCode::kTimeout, {"probe"}));
  const UltrasoundSimulator simulator(make_patient("abdomen")->anatomy, options.probe,
                                      options.seed);
  for (int i = 0; i < session.frame_count(); ++i) {
    const auto frame = source->next(session.frame_time(i) + milliseconds(70));
    ASSERT_TRUE(test::has_value(frame));
    EXPECT_EQ(frame->sequence, static_cast<std::uint64_t>(i));
    EXPECT_EQ(frame->acquired, session.frame_time(i) + milliseconds(40));
    EXPECT_EQ(frame->received, session.frame_time(i) + milliseconds(70));
    // The image shows the state at the physical time, not at the timestamp.
    const auto there =
        simulator.simulate(session.truth(i).ct_from_image, Timestamp{}, frame->sequence);
    EXPECT_TRUE(std::ranges::equal(there.pixels.pixels(), frame->pixels.pixels()));
  }
  EXPECT_TRUE(test::rejects(source->next(Timestamp::max()), ErrorCode::kEndOfStream, {"probe"}));
  source->stop();
  source->stop();
  EXPECT_TRUE(test::rejects(source->next(Timestamp::max()), ErrorCode::kCancelled, {"stopped"}));
}

TEST(SimulatedSessionTest, ImagesShowThePatientAtRestAtThePositionOfTheTissue) {
  SimulatedSessionOptions options = small();
  options.breathing.kind = BreathingKind::kRigid;
  options.breathing.period_variation = 0;
  const auto session = make(options);
  const ImageTruth truth = session.truth(3);
  const auto warp = session.breathing().warp(truth.physical);
  const Point<frames::Image> deep{{10, 70, 0}};
  EXPECT_GT((truth.rest.ct_from_image * deep).mm.z() - (truth.ct_from_image * deep).mm.z(), 1)
      << "inhaled tissue lies lower than at rest";
  EXPECT_LE(
      (warp->apply((truth.rest.ct_from_image * deep).mm) - (truth.ct_from_image * deep).mm).norm(),
      1e-8);
  auto frames = session.frames();
  double sum = 0;
  int count = 0;
  while (const auto frame = frames->next(Timestamp::max())) {
    EXPECT_EQ(frame->sequence, static_cast<std::uint64_t>(count));
    EXPECT_EQ(frame->acquired, session.frame_time(count));
    for (const auto grey : frame->pixels.pixels()) sum += grey;
    ++count;
  }
  EXPECT_EQ(count, session.frame_count());
  EXPECT_GT(sum / (80 * 60 * count), 15) << "the probe touches the patient";
}

TEST(SimulatedSessionTest, BreathingMovesDeformedTissueFromItsDeformedPosition) {
  SimulatedSessionOptions options = small();
  EXPECT_TRUE(make(options).undeformed());
  options.deformation.largest_mm = 8;
  const auto still = make(options);
  ASSERT_NE(still.deformation(), nullptr);
  EXPECT_FALSE(still.undeformed());
  options.breathing.kind = BreathingKind::kSmooth;
  const auto breathing = make(options);
  for (const auto& p : still.patient().targets()) {
    const Timestamp time = still.frame_time(3);
    const Vec lies = still.deformation()->apply(p.mm);
    EXPECT_EQ(still.warp(time)->apply(p.mm), lies);
    EXPECT_EQ(breathing.warp(time)->apply(p.mm), breathing.breathing().warp(time)->apply(lies));
  }
  // The image shows the tissue that lies there after the deformation, not the tissue that the CT
  // has at that position.
  const ImageTruth truth = still.truth(3);
  EXPECT_GT(
      std::abs((truth.rest.ct_from_image.translation_mm() - truth.ct_from_image.translation_mm())
                   .norm()),
      0.5);
  options = small();
  const auto flat = make(options).frames()->next(Timestamp::max());
  const auto bent = still.frames()->next(Timestamp::max());
  ASSERT_TRUE(flat && bent);
  EXPECT_FALSE(std::ranges::equal(flat->pixels.pixels(), bent->pixels.pixels()));
}

TEST(SimulatedSessionTest, EveryListedDeviceStartsAndDeliversData) {
  for (const SimulatedDevice& device : simulated_devices()) {
    SimulatedSessionOptions options = small();
    options.duration_s = 0.2;
    if (device.kind == "tracker") {
      const auto kind = tracker_kind_from(device.name);
      ASSERT_TRUE(kind) << device.name;
      options.tracker = *kind;
    } else {
      ASSERT_EQ(device.kind, "probe") << device.name;
      const auto probe = probe_model_from(device.name);
      ASSERT_TRUE(probe) << device.name;
      options.probe = *probe;
      options.probe.lines = 32;
    }
    const auto session = make(options);
    const auto pose = session.probe_poses()->next(Timestamp::max());
    const auto image = session.frames()->next(Timestamp::max());
    ASSERT_TRUE(pose && image) << device.name;
    EXPECT_EQ(pose->status, TrackingStatus::kOk) << device.name;
    EXPECT_GE(image->received, image->acquired) << device.name;
    EXPECT_FALSE(image->pixels.empty()) << device.name;
  }
  EXPECT_FALSE(probe_model_from("banana"));
}

TEST(SimulatedSessionTest, EqualSeedsGiveEqualBytes) {
  SimulatedSessionOptions options = small();
  options.tracker = TrackerKind::kOptical;
  options.duration_s = 0.2;
  const auto a = make(options);
  const auto b = make(options);
  const auto one = a.frames()->next(Timestamp::max());
  const auto two = b.frames()->next(Timestamp::max());
  ASSERT_TRUE(one && two);
  EXPECT_TRUE(std::ranges::equal(one->pixels.pixels(), two->pixels.pixels()));
  EXPECT_EQ(a.probe_poses()->next(Timestamp::max())->tracker_from_body,
            b.probe_poses()->next(Timestamp::max())->tracker_from_body);
}

TEST(SimulatedSessionTest, RejectsInvalidOptions) {
  SimulatedSessionOptions options = small();
  options.family = "dragon";
  const auto dragon = SimulatedSession::create(options);
  ASSERT_FALSE(dragon);
  EXPECT_THAT(dragon.error().message, HasSubstr("dragon"));
  options = small();
  options.duration_s = std::nan("");
  EXPECT_FALSE(SimulatedSession::create(options));
  options = small();
  options.breathing.period_s = 0;
  EXPECT_FALSE(SimulatedSession::create(options));
  options = small();
  options.image_timing.stamp_offset = options.image_timing.latency + Duration(1);
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"image latency"}));
  EXPECT_FALSE(tracker_kind_from("sonar"));
}

TEST(SimulatedSourceTest, DeliversASampleAtItsTimeOfArrival) {
  const auto session = make(small());
  Timestamp now{};
  const auto wait = [&now](Timestamp until) { now = std::max(now, until); };
  const auto source = source_of(session, wait);
  EXPECT_EQ(source->next(Timestamp(milliseconds(100))).error().code, ErrorCode::kTimeout);
  EXPECT_EQ(now, Timestamp(milliseconds(100)));
  for (int i = 0; i < 20; ++i) {
    const auto sample = source->next(Timestamp(std::chrono::seconds(10)));
    ASSERT_TRUE(sample);
    EXPECT_EQ(now, sample->received);
  }
  source->stop();
  EXPECT_EQ(source->next(Timestamp::max()).error().code, ErrorCode::kCancelled);
}

TEST(SimulatedSourceTest, MergesItsStreamsInOrderOfArrivalAndEnds) {
  const auto session = make(small());
  const auto source = source_of(session);
  std::vector<int> counts(source->streams().size());
  Timestamp newest = Timestamp::min();
  for (;;) {
    const auto sample = source->next(Timestamp::max());
    if (!sample) {
      EXPECT_EQ(sample.error().code, ErrorCode::kEndOfStream);
      break;
    }
    EXPECT_GE(sample->received, newest);
    newest = sample->received;
    ++counts[sample->stream];
  }
  ASSERT_EQ(counts.size(), 3u) << "probe, reference, images";
  EXPECT_EQ(counts[2], session.frame_count());
  EXPECT_GT(counts[0], session.frame_count()) << "poses come more often than images";
}

}  // namespace
}  // namespace nav::sim
