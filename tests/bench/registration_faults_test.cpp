// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "bench/registration/altered_sweep.hpp"
#include "bench/registration/fault_curve.hpp"
#include "nav/check.hpp"
#include "tests/support/matchers.hpp"

namespace nav::bench {
namespace {

using Vec = Eigen::Vector3d;
using registration::MisfitCause;
using ReferenceFromImage = Transform<frames::Reference, frames::Image>;

constexpr int kImages = 21;
constexpr double kStepS = 0.05;  // Time between images.
constexpr int kWidth = 81;
constexpr int kHeight = 101;
constexpr double kPixelMm = 1;
// The poses are products and spherical interpolations of doubles.
constexpr double kPoseMm = 1e-9;
constexpr double kPoseRad = 1e-9;
constexpr double kOutlineMm = 1e-12;
// Half a grey level for the rounding of each of the two images, and one level where the grey value
// is not linear between pixels.
constexpr double kGreyLevels = 2;

/// A hand that moves and rotates uniformly, so that poses between samples are exact.
ReferenceFromImage hand_at(double seconds) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.4 * seconds, Vec(1, 2, 2) / 3));
  return {turn, Vec(3, -4, 20 + 30 * seconds)};
}

/// Images whose grey values depend on the depth and angle from the face of a convex probe.
Sweep sweep_of(const std::function<double(double depth_mm, double angle_rad)>& grey, bool convex) {
  const SectorOutline outline{{0, -40}, 40, 130, 0.6};
  std::vector<TrackedImage> frames;
  for (int i = 0; i < kImages; ++i) {
    TrackedImage tracked{{}, hand_at(kStepS * i), Duration{0}};
    tracked.frame.acquired = Timestamp(from_seconds(kStepS * i));
    tracked.frame.grid = PixelGrid::centred(kWidth, kPixelMm, kPixelMm);
    if (convex) tracked.frame.outline = outline;
    std::vector<std::uint8_t> pixels;
    for (int row = 0; row < kHeight; ++row) {
      for (int column = 0; column < kWidth; ++column) {
        const Eigen::Vector2d p = tracked.frame.grid.at(column, row).mm.head<2>();
        const Eigen::Vector2d q = p - outline.apex_mm;
        const double depth_mm = convex ? q.norm() - outline.radius_min_mm : p.y();
        const double value = grey(depth_mm, std::atan2(q.x(), q.y()));
        pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)));
      }
    }
    tracked.frame.pixels = Image2d<std::uint8_t>(kWidth, kHeight, std::move(pixels));
    frames.push_back(std::move(tracked));
  }
  return *Sweep::create(std::move(frames), "planted");
}

Sweep flat_sweep() {
  return sweep_of([](double, double) { return 100; }, true);
}

TEST(AlteredSweepTest, ADelayedSweepHasThePosesOfOtherTimes) {
  const Sweep sweep = flat_sweep();
  const double last_s = kStepS * (kImages - 1);
  for (const double delay_s : {-0.2, -0.05, -0.015, 0.0, 0.015, 0.05, 0.2}) {
    const Sweep late = delayed(sweep, from_seconds(delay_s));
    int expected = 0;
    for (const TrackedImage& tracked : sweep.frames()) {
      const double pose_s = to_seconds(tracked.frame.acquired) - delay_s;
      expected += pose_s > -1e-9 && pose_s < last_s + 1e-9 ? 1 : 0;
    }
    ASSERT_EQ(late.frames().size(), static_cast<std::size_t>(expected)) << delay_s;
    for (const TrackedImage& tracked : late.frames()) {
      const double seconds = to_seconds(tracked.frame.acquired);
      EXPECT_TRUE(test::is_near(tracked.reference_from_image, hand_at(seconds - delay_s), kPoseMm,
                                kPoseRad))
          << delay_s;
    }
  }
  // With 200 ms, four images have no pose.
  EXPECT_EQ(delayed(sweep, from_seconds(0.2)).frames().front().frame.acquired,
            sweep.frames()[4].frame.acquired);
  EXPECT_EQ(delayed(sweep, from_seconds(-0.2)).frames().back().frame.acquired,
            sweep.frames()[kImages - 5].frame.acquired);
}

TEST(AlteredSweepTest, EnlargedPixelsEnlargeTheOutline) {
  const Sweep sweep = flat_sweep();
  const Sweep large = enlarged(sweep, 1.03);
  const UltrasoundImage& before = sweep.frames()[3].frame;
  const UltrasoundImage& after = large.frames()[3].frame;
  for (const auto& [column, row] : {std::pair{0, 0}, {80, 0}, {13, 100}}) {
    EXPECT_LT((after.grid.at(column, row).mm - 1.03 * before.grid.at(column, row).mm).norm(),
              kOutlineMm);
  }
  EXPECT_NEAR(after.outline->apex_mm.y(), -41.2, kOutlineMm);
  EXPECT_NEAR(after.outline->radius_min_mm, 41.2, kOutlineMm);
  EXPECT_NEAR(after.outline->radius_max_mm, 133.9, kOutlineMm);
  EXPECT_EQ(after.outline->half_angle_rad, before.outline->half_angle_rad);
}

/// Expects every echo at its new depth, at the same angle.
void expect_deepened(double factor, bool convex) {
  const double by_angle = convex ? 60 : 0;  // Beams of a linear probe have no angle.
  const auto grey = [&](double depth_mm, double angle_rad) {
    return 60 + 1.5 * depth_mm + by_angle * angle_rad;
  };
  const Sweep sweep = sweep_of(grey, convex);
  const Sweep deep = deepened(sweep, factor);
  const Sweep ideal = sweep_of(
      [&](double depth_mm, double angle_rad) { return grey(depth_mm / factor, angle_rad); },
      convex);
  const auto& outline = sweep.frames()[0].frame.outline;
  const UltrasoundImage& shown = deep.frames()[0].frame;
  EXPECT_EQ(shown.grid.mm_per_pixel, sweep.frames()[0].frame.grid.mm_per_pixel);
  int compared = 0;
  for (int row = 2; row < 85; ++row) {
    for (int column = 15; column < 66; ++column) {
      const Eigen::Vector2d p = shown.grid.at(column, row).mm.head<2>();
      const Eigen::Vector2d inner(p.x(), p.y() - 2);  // Keeps a distance for the source pixel and
                                                      // its neighbours.
      if (convex && !(outline->contains(p) && outline->contains(inner))) continue;
      EXPECT_NEAR(shown.pixels.at(column, row), ideal.frames()[0].frame.pixels.at(column, row),
                  kGreyLevels)
          << factor << ' ' << column << ' ' << row;
      ++compared;
    }
  }
  EXPECT_GT(compared, 3000);
}

TEST(AlteredSweepTest, DeeperEchoesStayOnTheirBeam) {
  // At a depth of 80 mm, 3 % are 3.6 grey levels.
  for (const double factor : {0.97, 1.03}) {
    expect_deepened(factor, true);
    expect_deepened(factor, false);
  }
}

TEST(AlteredSweepTest, ShallowerEchoesLeaveBlackPixelsAtTheBottom) {
  const Sweep shallow = deepened(flat_sweep(), 0.9);
  const UltrasoundImage& shown = shallow.frames()[0].frame;
  EXPECT_NEAR(shown.outline->radius_max_mm, 40 + 0.9 * 90, kOutlineMm);
  EXPECT_EQ(shown.pixels.at(40, 80), 100);
  EXPECT_EQ(shown.pixels.at(40, 83), 0);  // The echo would come from 92 mm, but the images end at
                                          // 90 mm.
  EXPECT_NEAR(deepened(flat_sweep(), 1.1).frames()[0].frame.outline->radius_max_mm, 130,
              kOutlineMm);
}

TEST(AlteredSweepTest, ACalibrationErrorIsEqualForAllImages) {
  const Sweep sweep = flat_sweep();
  const auto error_of = [&](const Sweep& wrong, std::size_t i) {
    return sweep.frames()[i].reference_from_image.inverse() *
           wrong.frames()[i].reference_from_image;
  };
  const Sweep wrong = miscalibrated(sweep, 2, 0.02, 7);
  const auto first = error_of(wrong, 0);
  EXPECT_NEAR(first.translation_mm().norm(), 2, kPoseMm);
  EXPECT_NEAR(Eigen::AngleAxisd(first.rotation()).angle(), 0.02, kPoseRad);
  EXPECT_TRUE(test::is_near(error_of(wrong, kImages - 1), first, kPoseMm, kPoseRad));
  const auto same = error_of(miscalibrated(sweep, 2, 0.02, 7), 5);
  EXPECT_TRUE(test::is_near(same, first, kPoseMm, kPoseRad));
  const auto other = error_of(miscalibrated(sweep, 2, 0.02, 8), 5);
  EXPECT_GT((other.translation_mm() - first.translation_mm()).norm(), 0.1);
}

TEST(FaultCaseTest, AFaultChangesTheSweepByItsKindAndSize) {
  const Sweep sweep = flat_sweep();
  const auto made = [&](FaultKind kind, double size) { return with_fault(sweep, {kind, size}, 3); };
  EXPECT_EQ(made(FaultKind::kNone, 0).frames().size(), sweep.frames().size());
  const TrackedImage late = made(FaultKind::kDelay, 200).frames().front();
  EXPECT_TRUE(test::is_near(late.reference_from_image, hand_at(0), kPoseMm, kPoseRad));
  EXPECT_EQ(late.frame.acquired, Timestamp(from_seconds(0.2)));
  EXPECT_NEAR(made(FaultKind::kPixelSize, 0.97).frames()[0].frame.grid.mm_per_pixel(0, 0), 0.97,
              kOutlineMm);
  const Sweep slow = made(FaultKind::kSoundSpeed, 0.97);
  EXPECT_NEAR(slow.frames()[0].frame.outline->radius_max_mm, 40 + 0.97 * 90, kOutlineMm);
  const auto error = sweep.frames()[0].reference_from_image.inverse() *
                     made(FaultKind::kCalibration, 4).frames()[0].reference_from_image;
  EXPECT_NEAR(error.translation_mm().norm(), 4, kPoseMm);
  EXPECT_NEAR(Eigen::AngleAxisd(error.rotation()).angle() * 180 / M_PI, 2.3, 0.05);
  const std::pair<FaultKind, Vec> shifts[] = {{FaultKind::kShiftAcross, {4, 0, 0}},
                                              {FaultKind::kShiftDeep, {0, 4, 0}},
                                              {FaultKind::kShiftOut, {0, 0, 4}}};
  for (const auto& [kind, mm] : shifts) {
    const auto off = sweep.frames()[5].reference_from_image.inverse() *
                     made(kind, 4).frames()[5].reference_from_image;
    EXPECT_LT((off.translation_mm() - mm).norm(), kPoseMm) << to_string(kind);
    EXPECT_LT(Eigen::AngleAxisd(off.rotation()).angle(), kPoseRad) << to_string(kind);
  }
  EXPECT_THROW(made(FaultKind::kBreathing, 6), Bug);
}

sim::SimulatedSessionOptions short_session(double duration_s) {
  sim::SimulatedSessionOptions options;
  options.seed = 501;
  options.duration_s = duration_s;
  options.frame_rate_hz = 4;
  return options;
}

TEST(FaultCaseTest, ADeformedSessionKnowsThePositionsOfItsTargets) {
  const auto session = make_faulty_session({FaultKind::kDeformation, 8}, short_session(0.5));
  ASSERT_TRUE(test::has_value(session));
  double largest = 0;
  double sum = 0;
  for (std::size_t i = 0; i < session->targets.size(); ++i) {
    const double mm = (session->lying[i] - session->targets[i]).v.norm();
    largest = std::max(largest, mm);
    sum += mm * mm;
  }
  EXPECT_NEAR(largest, 8, 1e-9);
  const double rms = std::sqrt(sum / static_cast<double>(session->targets.size()));
  EXPECT_GT(rms, 1);
  EXPECT_NEAR(error_mm(*session, session->truth), rms, 1e-9);
}

/// Largest distance between the truth of an image and the truth at rest, mm.
double moved_mm(const SessionCase& session) {
  const auto centre = session.sweep.centroid();
  double most = 0;
  for (const auto& following : session.following_truth) {
    most = std::max(most, (following * centre - session.truth * centre).v.norm());
  }
  return most;
}

TEST(FaultCaseTest, ABreathingSessionMovesByItsSize) {
  const auto half = make_faulty_session({FaultKind::kBreathing, 6}, short_session(4));
  const auto whole = make_faulty_session({FaultKind::kBreathing, 12}, short_session(4));
  ASSERT_TRUE(test::has_value(half) && test::has_value(whole));
  // Breaths differ by up to 15 %, and the edge of the liver moves less than its middle.
  EXPECT_GT(moved_mm(*half), 0.5 * 6);
  EXPECT_LT(moved_mm(*half), 1.3 * 6);
  EXPECT_NEAR(moved_mm(*whole) / moved_mm(*half), 2, 0.2);
  for (std::size_t i = 0; i < whole->targets.size(); ++i) {
    EXPECT_EQ(whole->lying[i].mm, whole->targets[i].mm);
  }
}

TEST(FaultCaseTest, ASessionHasVisibleTargetsAndTrackerErrors) {
  const auto session = make_faulty_session({}, short_session(2));
  ASSERT_TRUE(test::has_value(session));
  const FaultCase made = fault_case(*session, 501, nullptr);
  EXPECT_FALSE(made.targets.empty());
  EXPECT_LT(made.targets.size(), session->targets.size());
  EXPECT_NEAR(target_error_mm(made.start, made.truth, made.targets, made.lying), 5, 1e-6);
  double squares = 0;
  for (std::size_t i = 0; i < made.sweep.frames().size(); ++i) {
    squares += (made.sweep.frames()[i].reference_from_image.translation_mm() -
                session->sweep.frames()[i].reference_from_image.translation_mm())
                   .squaredNorm();
  }
  // Nine images determine the RMS within a factor of two.
  const double rms = std::sqrt(squares / static_cast<double>(made.sweep.frames().size()) / 3);
  EXPECT_GT(rms, 0.5 * kTrackerMm);
  EXPECT_LT(rms, 2 * kTrackerMm);
}

FaultTrial trial(const Fault& fault, double error_mm, bool accepted, bool warned,
                 std::optional<MisfitCause> named) {
  FaultTrial t;
  t.fault = fault;
  t.solved = true;
  t.error_mm = error_mm;
  t.accepted = accepted;
  t.warned = warned;
  t.predicted_mm = 0.5;
  t.named = named;
  t.misfits_cpu_s = 0.010;
  return t;
}

TEST(FaultCurveTest, CountsKnownTrials) {
  const Fault none;
  const Fault late{FaultKind::kDelay, 100};
  const Fault later{FaultKind::kDelay, 200};
  std::vector<FaultTrial> trials{trial(late, 1, true, false, {}),
                                 trial(none, 0.2, true, false, {}),
                                 trial(late, 2, true, true, MisfitCause::kDelay),
                                 trial(late, 4, true, true, MisfitCause::kMotion),
                                 trial(late, 9, false, false, MisfitCause::kDelay),
                                 trial(later, 9, false, false, {})};
  trials.push_back({});
  trials.back().fault = late;  // Rejected before a pose was found.
  const std::vector<FaultPoint> points = count_faults(trials);
  ASSERT_EQ(points.size(), 3U);
  EXPECT_EQ(points[0].fault, late);
  EXPECT_EQ(points[1].fault, none);
  EXPECT_EQ(points[2].fault, later);
  const FaultPoint& p = points[0];
  EXPECT_EQ(p.runs, 5);
  EXPECT_EQ(p.solved, 4);
  EXPECT_EQ(p.clear, 1);
  EXPECT_EQ(p.warned, 2);
  EXPECT_EQ(p.refused, 2);
  EXPECT_EQ(p.false_accepts, 1);  // The trial with 4 mm. The trial with 9 mm was rejected.
  EXPECT_EQ(p.named, 3);
  EXPECT_EQ(p.named_right, 2);
  EXPECT_NEAR(p.error_mean_mm, 7.0 / 3, 1e-12);
  EXPECT_EQ(p.error_max_mm, 4);
  EXPECT_EQ(p.actual_over_predicted, 4);  // The trial with 2 mm.
  EXPECT_NEAR(p.misfits_cpu_ms, 10, 1e-12);
  EXPECT_EQ(points[2].refused, 1);
  EXPECT_TRUE(std::isnan(points[2].error_mean_mm) && std::isnan(points[2].error_max_mm));
  EXPECT_TRUE(std::isnan(points[2].actual_over_predicted));
}

TEST(FaultCurveTest, AnErrorOfThreeMillimetresCountsAsCorrect) {
  EXPECT_FALSE(trial({}, kFalseAcceptMm, true, true, {}).false_accept());
  EXPECT_TRUE(trial({}, kFalseAcceptMm + 0.01, true, true, {}).false_accept());
  EXPECT_TRUE(trial({}, NAN, true, false, {}).false_accept());
  EXPECT_FALSE(trial({}, 9, false, false, {}).false_accept());
}

TEST(FaultCurveTest, TheTableNamesEveryFaultWithItsSize) {
  std::vector<FaultTrial> trials;
  for (const Fault& fault : default_faults()) trials.push_back(trial(fault, 4, true, true, {}));
  const std::string text = to_text(count_faults(trials), "planted");
  for (const char* words :
       {"none", "-200 ms", "+50 ms", "x 0.985", "x 1.03", "2 mm, 1.15 deg", "4 mm, 2.29 deg",
        "breathing    12 mm", "deformation  8 mm", "shift_across 4 mm", "shift_deep   4 mm",
        "shift_out    4 mm", "23 of 23 runs"}) {
    EXPECT_NE(text.find(words), std::string::npos) << words << text;
  }
}

/// A simulated sweep along the ribs. Its images are 200 ms earlier than their poses.
TEST(FaultCurveTest, ALongDelayIsNamedAndDoesNotMoveThePose) {
  CaseStore store;
  FaultCurveOptions options;
  options.sweeps.first_seed = 501;
  options.sweeps.patients = 1;
  options.sweeps.paths = {SweepPath::kSlide};
  options.sweeps.hands = {};
  options.faults = {{}, {FaultKind::kDelay, -200}};
  double done = 0;
  const auto trials = run_faults(options, store, [&](double fraction) { done = fraction; });
  ASSERT_TRUE(test::has_value(trials));
  EXPECT_EQ(done, 1);
  const std::vector<FaultPoint> points = count_faults(*trials);
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].clear, 1);
  EXPECT_EQ(points[0].named, 0);
  EXPECT_LT(points[0].error_max_mm, 0.5);
  EXPECT_GT(points[0].misfits_cpu_ms, 0);
  EXPECT_EQ(points[1].solved, 1);
  EXPECT_EQ(points[1].clear, 0);
  EXPECT_EQ(points[1].false_accepts, 0);
  EXPECT_LT((*trials)[1].error_mm, 1);
  EXPECT_EQ(points[1].named_right, 1);
}

}  // namespace
}  // namespace nav::bench
