// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/uncertainty/misfit.hpp"

#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <limits>
#include <map>
#include <vector>

#include "registration/acceptance.hpp"
#include "tests/registration/uneven_hand.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;
using ::testing::HasSubstr;
using ImagePose = Transform<frames::Ct, frames::Image>;
using Rest = std::function<test::AtRest(int, const Vec&, const Vec&)>;

constexpr int kImages = test::kHandImages;
constexpr double kStepS = test::kHandStepS;
using test::uneven_hand_at;

Sweep sweep_of(const Rest& rest) { return test::uneven_sweep(rest); }

Rest at_rest() {
  return [](int, const Vec& now, const Vec& beam) -> test::AtRest { return {now, beam}; };
}

const Sweep& right_sweep() {
  static const Sweep instance = sweep_of(at_rest());
  return instance;
}

Sweep altered(const std::function<void(int, TrackedImage&)>& change) {
  std::vector<TrackedImage> frames = right_sweep().frames();
  for (int f = 0; f < kImages; ++f) change(f, frames[static_cast<std::size_t>(f)]);
  return *Sweep::create(std::move(frames), "altered");
}

ImageRegistrationOptions options() { return test::hand_options(); }

ImageRegistrationResult fitted(const Sweep& sweep,
                               const ImageRegistrationOptions& solver = options()) {
  CollectingDiagnostics diagnostics;
  auto result = register_sweep(test::hand_ct(), sweep, test::true_pose(), solver, diagnostics);
  EXPECT_TRUE(test::has_value(result));
  return std::move(result).value();
}

std::map<MisfitCause, Misfit> by_cause(const std::vector<Misfit>& misfits) {
  std::map<MisfitCause, Misfit> out;
  for (const Misfit& misfit : misfits) out.emplace(misfit.cause, misfit);
  return out;
}

/// Expects a rejection with a reason that contains \p words.
void expect_rejected(const ImageRegistrationResult& result, const std::string& words) {
  const Decision decision = decide(result, {}, {{0, 0, 0}});
  EXPECT_FALSE(decision.accepted);
  std::string reasons;
  for (const std::string& reason : decision.reasons) reasons += reason + "; ";
  EXPECT_THAT(reasons, HasSubstr(words));
}

/// Expects a pose within \p right_mm although images and poses disagree, and \p words in a warning
/// or a reason.
void expect_right_and_told(const ImageRegistrationResult& result, double right_mm,
                           const std::string& words) {
  EXPECT_LT(test::cube_error_mm(result.ct_from_reference, test::true_pose()), right_mm);
  const Decision decision = decide(result, {}, {{0, 0, 0}});
  EXPECT_NE(decision.verdict(), Verdict::kAccept);
  std::string told;
  for (const std::string& one : decision.reasons) told += one + "; ";
  for (const std::string& one : decision.warnings) told += one + "; ";
  EXPECT_THAT(told, HasSubstr(words));
}

TEST(MisfitTest, FindsNoMisfitInCorrectInput) {
  const auto result = fitted(right_sweep());
  ASSERT_EQ(result.misfits.size(), static_cast<std::size_t>(kMisfitCauses));
  for (const Misfit& misfit : result.misfits) {
    EXPECT_LT(misfit.excess_mm(), 0.35) << to_string(misfit.cause);
    EXPECT_LT(misfit.found_mm, 0.8) << to_string(misfit.cause);
    EXPECT_GT(misfit.noise_mm, 0) << to_string(misfit.cause);
  }
  EXPECT_TRUE(decide(result, {}, {{0, 0, 0}}).accepted);
}

TEST(MisfitTest, FindsADelayWithItsSignAndSize) {
  for (const double late_s : {-0.08, 0.08}) {
    // The poses are those of a time late_s before the images.
    const Sweep sweep = altered([&](int f, TrackedImage& tracked) {
      tracked.reference_from_image =
          test::true_pose().inverse() * uneven_hand_at(kStepS * f - late_s);
    });
    const auto result = fitted(sweep);
    const Misfit delay = by_cause(result.misfits).at(MisfitCause::kDelay);
    EXPECT_NEAR(delay.values.at(0), late_s, 0.15 * std::abs(late_s));
    EXPECT_NEAR(result.errors.delay_s, late_s, 3 * result.error_deviations[0]);
    EXPECT_GT(delay.excess_mm(), 0.7);
    expect_right_and_told(result, 1,
                          late_s > 0 ? "later than their poses: lower --temporal-offset-ms"
                                     : "earlier than their poses: raise --temporal-offset-ms");
  }
}

TEST(MisfitTest, FindsAWrongPixelSizeAlongEachAxis) {
  // The echoes of this scene alone appear 1.5 % too deep.
  const Misfit right = by_cause(fitted(right_sweep()).misfits).at(MisfitCause::kPixelSize);
  for (const int axis : {0, 1}) {
    const Sweep sweep = altered([&](int, TrackedImage& tracked) {
      auto& grid = tracked.frame.grid;
      grid.mm_per_pixel.col(axis) *= 1.04;
      grid.origin_mm[axis] *= 1.04;
    });
    const auto result = fitted(sweep);
    const Misfit size = by_cause(result.misfits).at(MisfitCause::kPixelSize);
    ASSERT_EQ(size.values.size(), 2U);
    const auto depth_first = static_cast<std::size_t>(1 - axis);
    const auto off = [&](std::size_t i) { return size.values[i] - right.values[i]; };
    EXPECT_NEAR(off(depth_first), -0.04, 0.02) << axis;
    EXPECT_NEAR(off(1 - depth_first), 0, 0.012) << axis;
    expect_right_and_told(result, 2, "pixel size");
  }
}

TEST(MisfitTest, FindsAWrongCalibrationOfTheProbe) {
  const ImagePose wrong(Eigen::Quaterniond(Eigen::AngleAxisd(0.03, Vec(1, 1, 1).normalized())),
                        Vec(2, -2, 2));
  const Transform<frames::Image, frames::Image> error(wrong.rotation(), wrong.translation_mm());
  const Sweep sweep = altered([&](int, TrackedImage& tracked) {
    tracked.reference_from_image = tracked.reference_from_image * error;
  });
  const auto result = fitted(sweep);
  expect_rejected(result, "probe calibration error");
}

TEST(MisfitTest, FindsThatThePatientMoved) {
  const Sweep sweep = sweep_of([](int f, const Vec& now, const Vec& beam) -> test::AtRest {
    return {now - 2.5 * std::sin(0.3 * f) * Vec(0, 0.6, 0.8), beam};
  });
  const auto result = fitted(sweep);
  EXPECT_GT(by_cause(result.misfits).at(MisfitCause::kMotion).excess_mm(), 1.0);
  expect_rejected(result, "motion of the patient");
}

TEST(MisfitTest, FindsDeformedTissue) {
  const Sweep sweep = sweep_of([](int, const Vec& now, const Vec& beam) -> test::AtRest {
    const double x = now.x() / 40, z = now.z() / 40;
    return {now - 3 * Vec(z * z, x * x, x * z), beam};
  });
  const auto result = fitted(sweep);
  expect_rejected(result, "deformed relative to the CT");
  const Misfit bend = by_cause(result.misfits).at(MisfitCause::kBend);
  EXPECT_GT(bend.excess_mm(), 0.9);
  EXPECT_TRUE(bend.values.empty());
  // The misfit is part of the predicted error.
  EXPECT_GE(result.tre_rms_mm({{0, 0, 0}}), bend.excess_mm());
  EXPECT_LT(result.clusters.tre_rms_mm({{0, 0, 0}}), bend.excess_mm());
}

TEST(MisfitTest, ReportsTheErrorsThatItWouldNotNotice) {
  const auto right = by_cause(fitted(right_sweep()).misfits);
  const double delay_s = right.at(MisfitCause::kDelay).unnoticed;
  EXPECT_GT(delay_s, 0.01);
  EXPECT_LT(delay_s, 0.1);
  EXPECT_GT(right.at(MisfitCause::kPixelSize).unnoticed, 0.003);
  EXPECT_LT(right.at(MisfitCause::kPixelSize).unnoticed, 0.05);
  EXPECT_GT(right.at(MisfitCause::kCalibration).unnoticed, 0.3);
  EXPECT_LT(right.at(MisfitCause::kCalibration).unnoticed, 10);
  for (const MisfitCause cause : {MisfitCause::kMotion, MisfitCause::kBend}) {
    // Without noise, the value is not below the warning limit.
    const double telling_mm = kTellingMm[static_cast<std::size_t>(cause)];
    EXPECT_GT(right.at(cause).unnoticed, telling_mm) << to_string(cause);
    EXPECT_LT(right.at(cause).unnoticed, 2 * telling_mm) << to_string(cause);
  }
  const auto found = [](double late_s) {
    const Sweep sweep = altered([&](int f, TrackedImage& tracked) {
      tracked.reference_from_image =
          test::true_pose().inverse() * uneven_hand_at(kStepS * f - late_s);
    });
    return by_cause(fitted(sweep).misfits).at(MisfitCause::kDelay);
  };
  EXPECT_FALSE(found(0.3 * delay_s).telling());
  EXPECT_TRUE(found(2.5 * delay_s).telling());
}

TEST(MisfitTest, DescribesTheErrorsThatItWouldNotNotice) {
  Misfit delay{MisfitCause::kDelay};
  delay.unnoticed = 0.034;
  Misfit size{MisfitCause::kPixelSize};
  size.unnoticed = 0.009;
  Misfit calibration{MisfitCause::kCalibration};
  calibration.unnoticed = std::numeric_limits<double>::infinity();
  calibration.unnoticed_along = {-0.99, 0.1, 0.1};
  const std::string tracked = " (a needle with its own tracker would be wrong by as much)";
  Misfit motion{MisfitCause::kMotion};
  motion.unnoticed = std::numeric_limits<double>::infinity();
  Misfit bend{MisfitCause::kBend};
  bend.unnoticed = 1.12;
  EXPECT_EQ(
      unnoticed_in_words({delay, size, calibration, motion, bend}),
      "this sweep cannot show a delay between images and poses below 34 ms, an error of the pixel "
      "size below 0.9 %, a probe calibration error of any size across the images" +
          tracked +
          ", any motion of the patient, tissue deformation below 1.1 mm RMS relative to the CT");
  calibration.unnoticed = 12;
  calibration.unnoticed_along = {0, 0.6, -0.8};
  EXPECT_EQ(unnoticed_in_words({calibration}),
            "this sweep cannot show a probe calibration error below 12 mm along (0.00, 0.60, "
            "-0.80) of the image axes" +
                tracked);
  EXPECT_EQ(unnoticed_in_words({}), "");
}

/// A hand that turns only about the lateral axis of its images.
ImagePose fanning_hand_at(int f) {
  const double t = static_cast<double>(f) / (kImages - 1);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.9 * (t - 0.5), Vec::UnitX()));
  return {turn, Vec(0, 0, 30 * (t - 0.5)) - turn * Vec(0, 45, 0)};
}

/// A fan whose images have a calibration error.
Sweep fan_off_by(const Vec& shift_mm, const Vec& turn_rad = Vec::Zero()) {
  static const Sweep fan =
      test::images_along(test::hand_patient(), kImages, fanning_hand_at, at_rest()).sweep;
  std::vector<TrackedImage> frames = fan.frames();
  for (TrackedImage& tracked : frames) {
    const UltrasoundImage& frame = tracked.frame;
    const Vec middle =
        frame.grid.at(0.5 * (frame.pixels.width() - 1), 0.5 * (frame.pixels.height() - 1)).mm;
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    if (turn_rad.norm() > 0) turn = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized());
    const Transform<frames::Image, frames::Image> error(turn, middle - turn * middle + shift_mm);
    tracked.reference_from_image = tracked.reference_from_image * error;
  }
  return *Sweep::create(std::move(frames), "shifted");
}

TEST(MisfitTest, ReportsAShiftAlongTheTurningAxisAsHidden) {
  const auto right = fitted(fan_off_by({0, 0, 0}));
  const Misfit known = by_cause(right.misfits).at(MisfitCause::kCalibration);
  ASSERT_EQ(known.unnoticed_along.size(), 3U);
  EXPECT_GT(std::abs(known.unnoticed_along[0]), 0.99);
  EXPECT_GT(known.unnoticed, 20);
  EXPECT_THAT(unnoticed_in_words(right.misfits), HasSubstr("across the images"));
  // The shift is hidden: the pose compensates for it.
  const auto across = fitted(fan_off_by({8, 0, 0}));
  EXPECT_TRUE(decide(across, {}, {{0, 0, 0}}).accepted);
  EXPECT_NEAR(test::cube_error_mm(across.ct_from_reference, test::true_pose()), 8, 0.5);
  // Other shifts are not hidden.
  EXPECT_FALSE(decide(fitted(fan_off_by({0, 8, 0})), {}, {{0, 0, 0}}).accepted);
  // A probe that turns about two axes hides no shift of this size.
  EXPECT_LT(by_cause(fitted(right_sweep()).misfits).at(MisfitCause::kCalibration).unnoticed, 10);
}

TEST(MisfitTest, TheUncertaintyOfTheCalibrationIsPartOfThePredictedError) {
  constexpr double kSigmaMm = 1.5;
  constexpr double kTurnRad = kSigmaMm / 60;
  const auto known = fitted(fan_off_by({0, 0, 0}));
  ImageRegistrationOptions solver = options();
  solver.calibration_sigma_mm = kSigmaMm;
  const auto unsure = fitted(fan_off_by({0, 0, 0}), solver);
  EXPECT_EQ(unsure.ct_from_reference.matrix(), known.ct_from_reference.matrix());
  std::vector<ImageRegistrationResult> shifted;
  std::vector<ImageRegistrationResult> turned;
  for (int axis = 0; axis < 3; ++axis) {
    shifted.push_back(fitted(fan_off_by(kSigmaMm * Vec::Unit(axis))));
    turned.push_back(fitted(fan_off_by({0, 0, 0}, kTurnRad * Vec::Unit(axis))));
  }
  // The variance of six independent errors is the sum of the squared displacements of the target.
  // Far from the images, rotations count as much as shifts.
  const Point<frames::Ct> near{{20, -10, 30}};
  const Point<frames::Ct> far{{20, -10, 230}};
  for (const Point<frames::Ct>& target : {near, far}) {
    const auto squares_of = [&](const std::vector<ImageRegistrationResult>& results) {
      double squares = 0;
      const Point<frames::Reference> held = known.ct_from_reference.inverse() * target;
      for (const auto& result : results) {
        squares += (result.ct_from_reference * held - target).v.squaredNorm();
      }
      return squares;
    };
    const double shifts = squares_of(shifted);
    const double turns = squares_of(turned);
    EXPECT_GT(shifts, kSigmaMm * kSigmaMm);  // The shift across the images alone contributes its
                                             // full size.
    if (target.mm == far.mm) {
      EXPECT_GT(turns, 0.8 * shifts);
    }
    const double more =
        std::pow(unsure.tre_rms_mm(target), 2) - std::pow(known.tre_rms_mm(target), 2);
    const double squares = shifts + turns;
    EXPECT_NEAR(std::sqrt(more), std::sqrt(squares), 0.15 * std::sqrt(squares));
  }
  solver = options();
  solver.calibration_sigma_mm = -1;
  EXPECT_FALSE(validate(solver).has_value());
}

TEST(MisfitTest, AProbeThatHardlyMovesShowsNoDelay) {
  std::vector<TrackedImage> frames = right_sweep().frames();
  // The timestamps are so far apart that the hand hardly moves around any of them.
  for (std::size_t f = 0; f < frames.size(); ++f) {
    frames[f].frame.acquired = Timestamp(from_seconds(2.0 * static_cast<double>(f)));
  }
  const auto misfits = by_cause(fitted(*Sweep::create(std::move(frames), "slow")).misfits);
  const Misfit& delay = misfits.at(MisfitCause::kDelay);
  EXPECT_EQ(delay.found_mm, 0);
  EXPECT_EQ(delay.noise_mm, 0);
  EXPECT_EQ(delay.excess_mm(), 0);
  EXPECT_EQ(delay.unnoticed, std::numeric_limits<double>::infinity());
  EXPECT_THAT(in_words(delay), HasSubstr("delay"));
}

TEST(MisfitTest, ADistantReferenceChangesNothing) {
  const Vec far(3e4, -2e4, 5e4);
  const Sweep sweep = altered([&](int, TrackedImage& tracked) {
    const auto& pose = tracked.reference_from_image;
    tracked.reference_from_image = {pose.rotation(), pose.translation_mm() + far};
  });
  CollectingDiagnostics diagnostics;
  const auto& truth = test::true_pose();
  const Transform<frames::Ct, frames::Reference> start(
      truth.rotation(), truth.translation_mm() - truth.rotation() * far);
  const auto away = register_sweep(test::hand_ct(), sweep, start, options(), diagnostics);
  ASSERT_TRUE(test::has_value(away));
  const auto here = by_cause(fitted(right_sweep()).misfits);
  for (const Misfit& misfit : away->misfits) {
    EXPECT_NEAR(misfit.found_mm, here.at(misfit.cause).found_mm, 1e-4) << to_string(misfit.cause);
    EXPECT_NEAR(misfit.noise_mm, here.at(misfit.cause).noise_mm, 1e-4) << to_string(misfit.cause);
  }
}

TEST(MisfitTest, ASimilarityWithoutPatchTermsHasNoMisfits) {
  ImageRegistrationOptions solver = options();
  solver.similarity = Similarity::kMutualInformation;
  EXPECT_TRUE(fitted(right_sweep(), solver).misfits.empty());
}

TEST(MisfitTest, ExcessIsThePartBeyondNoise) {
  Misfit misfit{MisfitCause::kBend, 2, 1, 5};
  EXPECT_DOUBLE_EQ(misfit.excess_mm(), 1);
  misfit.noise_mm = 1.2;
  EXPECT_EQ(misfit.excess_mm(), 0);
}

TEST(MisfitTest, OnlySignificantMisfitsArePartOfThePredictedError) {
  const Misfit delay{MisfitCause::kDelay, 0.5, 0, 1};
  const auto bent = [](double mm) { return Misfit{MisfitCause::kBend, mm, 0, 1}; };
  EXPECT_EQ(telling_excess_mm({bent(0.47)}), 0);  // This may be chance: it is less than half of
                                                  // 0.95.
  EXPECT_DOUBLE_EQ(telling_excess_mm({bent(0.75 * 0.95)}), 0.5 * 0.75 * 0.95);
  EXPECT_DOUBLE_EQ(telling_excess_mm({delay, bent(0.6)}), 0.5);
  EXPECT_DOUBLE_EQ(telling_excess_mm({delay, bent(1)}), 1);
  EXPECT_EQ(telling_excess_mm({}), 0);
  EXPECT_TRUE(std::isnan(telling_excess_mm({delay, {MisfitCause::kMotion, NAN, 0, 1}})));
}

TEST(ImageMotionTest, EqualsTheMotionOfTheHand) {
  const auto motions = image_motions(right_sweep(), right_sweep());
  ASSERT_EQ(motions.size(), static_cast<std::size_t>(kImages));
  const auto reference_from_ct = test::true_pose().inverse();
  for (const int f : {5, 20, 40}) {
    const ImageMotion& motion = motions[static_cast<std::size_t>(f)];
    EXPECT_NEAR(motion.time_s, kStepS * f, 1e-9);
    const auto at = [&](double s) {
      const double middle = 0.5 * (90 - 1);
      const auto& grid = right_sweep().frames()[0].frame.grid;
      return (reference_from_ct * uneven_hand_at(s) * grid.at(middle, middle)).mm;
    };
    // A chord over 0.2 s, from the image before to the image after.
    const Vec velocity = (at(kStepS * (f + 1)) - at(kStepS * (f - 1))) / (2 * kStepS);
    EXPECT_LT((motion.velocity_mm_s - velocity).norm(), 1e-9);
    EXPECT_LT((motion.middle_mm - at(kStepS * f)).norm(), 1e-9);
    const Eigen::AngleAxisd turn(reference_from_ct.rotation() *
                                 uneven_hand_at(kStepS * (f + 1)).rotation() *
                                 uneven_hand_at(kStepS * (f - 1)).rotation().conjugate() *
                                 reference_from_ct.rotation().conjugate());
    EXPECT_LT((motion.turn_rad_s - turn.angle() / (2 * kStepS) * turn.axis()).norm(), 1e-9);
  }
}

TEST(ImageMotionTest, MotionOfSomeImagesUsesTheWholeSweep) {
  std::vector<TrackedImage> some;
  for (std::size_t f = 0; f < right_sweep().frames().size(); f += 10) {
    some.push_back(right_sweep().frames()[f]);
  }
  const auto all = image_motions(right_sweep(), right_sweep());
  const auto motions = image_motions(*Sweep::create(some, "some"), right_sweep());
  ASSERT_EQ(motions.size(), some.size());
  for (std::size_t i = 0; i < some.size(); ++i) {
    EXPECT_EQ(motions[i].velocity_mm_s, all[10 * i].velocity_mm_s);
  }
}

TEST(ImageMotionTest, MotionOfOneImageIsZero) {
  const auto one = Sweep::create({right_sweep().frames()[3]}, "one");
  const auto motions = image_motions(*one, *one);
  ASSERT_EQ(motions.size(), 1U);
  EXPECT_EQ(motions[0].time_s, 0);
  EXPECT_EQ(motions[0].velocity_mm_s, Vec::Zero());
  EXPECT_EQ(motions[0].turn_rad_s, Vec::Zero());
}

}  // namespace
}  // namespace nav::registration
