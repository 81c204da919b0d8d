// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/error_solver.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "registration/acceptance.hpp"
#include "registration/prepared.hpp"
#include "tests/registration/uneven_hand.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;
using test::hand_ct;
using test::hand_options;
using test::kHandImages;
using test::kHandStepS;
using test::uneven_hand_at;
using test::uneven_sweep_late_by;

PreparedSweep prepared(const Sweep& sweep) {
  CollectingDiagnostics diagnostics;
  auto made = PreparedSweep::create(sweep, hand_options(), diagnostics);
  EXPECT_TRUE(test::has_value(made));
  return std::move(made).value();
}

ImageErrors some_errors() {
  return {.delay_s = 0.07,
          .depth_scale = 1.02,
          .width_scale = 0.99,
          .pressed_mm = 3,
          .turn_rad = {0.01, -0.02, 0.015},
          .shift_mm = {0.6, -0.4, 0.8}};
}

TEST(ErrorSolverTest, NoErrorsChangeNothing) {
  const PreparedSweep sweep = prepared(uneven_sweep_late_by(0));
  const PatchSet& patches = sweep.levels().back().patches;
  const PatchSet same = corrected(patches, {}, sweep.motions(), sweep.path());
  ASSERT_EQ(same.patches.size(), patches.patches.size());
  for (std::size_t i = 0; i < patches.patches.size(); ++i) {
    EXPECT_EQ(same.patches[i].centre_mm, patches.patches[i].centre_mm);
  }
  EXPECT_TRUE(ImageErrors().none());
  EXPECT_EQ(ImageErrors::of(some_errors().vector()).vector(), some_errors().vector());
}

TEST(ErrorSolverTest, TwistsAreTheDerivativesOfTheCorrection) {
  constexpr double kStep = 1e-4;
  const PreparedSweep sweep = prepared(uneven_sweep_late_by(0));
  const PatchSet& patches = sweep.levels().back().patches;
  const auto at = [&](const ErrorVector& values) {
    return corrected(patches, ImageErrors::of(values), sweep.motions(), sweep.path());
  };
  const ErrorVector values = some_errors().vector();
  const PatchSet here = at(values);
  const auto twists = twists_by_errors(patches, some_errors(), sweep.motions(), sweep.path());
  for (Eigen::Index k = 0; k < kErrorParameters; ++k) {
    const ErrorVector step = kStep * ErrorVector::Unit(k);
    const PatchSet up = at(values + step);
    const PatchSet down = at(values - step);
    for (std::size_t i = 0; i < patches.patches.size(); i += 50) {
      const auto slope = [&](auto of) -> Vec {
        return (of(up.patches[i]) - of(down.patches[i])) / (2 * kStep);
      };
      const Vec turn = twists[i].col(k).head<3>();
      // The speed is interpolated between images, and the path integrated in steps.
      const double tolerance = k == 0 ? 0.5 : 1e-4;
      EXPECT_LT(
          (slope([](const Patch& p) { return p.centre_mm; }) - twists[i].col(k).tail<3>()).norm(),
          tolerance)
          << k;
      EXPECT_LT(
          (slope([](const Patch& p) { return p.beam; }) - turn.cross(here.patches[i].beam)).norm(),
          k == 0 ? 0.02 : 1e-4)
          << k;
    }
  }
}

TEST(ErrorSolverTest, ADelayMovesTheImagesAlongThePathOfTheProbe) {
  // A quarter of a second at up to 60 mm/s, and back to the true path.
  const PreparedSweep late = prepared(uneven_sweep_late_by(0.25));
  const PatchSet& patches = late.levels().back().patches;
  const PatchSet moved = corrected(patches, {.delay_s = 0.25}, late.motions(), late.path());
  double before = 0;
  double after = 0;
  for (std::size_t i = 0; i < patches.patches.size(); ++i) {
    const int frame = patches.patches[i].frame;
    if (kHandStepS * frame > kHandStepS * (kHandImages - 1) - 0.5) continue;  // The path ends.
    const auto true_of_late = test::true_pose().inverse() * uneven_hand_at(kHandStepS * frame) *
                              uneven_hand_at(kHandStepS * frame - 0.25).inverse() *
                              test::true_pose();
    const Vec truth = (true_of_late * Point<frames::Reference>{patches.patches[i].centre_mm}).mm;
    before = std::max(before, (patches.patches[i].centre_mm - truth).norm());
    after = std::max(after, (moved.patches[i].centre_mm - truth).norm());
  }
  EXPECT_GT(before, 8);
  EXPECT_LT(after, 1.5);
}

TEST(ErrorSolverTest, FindsADelayAWrongScaleAndThePoseTogether) {
  for (const double late_s : {-0.18, 0.06, 0.3}) {
    std::vector<TrackedImage> frames = uneven_sweep_late_by(late_s).frames();
    for (TrackedImage& tracked : frames) {
      tracked.frame.grid.mm_per_pixel *= 1.02;
      tracked.frame.grid.origin_mm *= 1.02;
    }
    const Sweep sweep = *Sweep::create(std::move(frames), "late and large");
    CollectingDiagnostics diagnostics;
    const auto result = register_sweep(
        hand_ct(), sweep, test::off_by(test::true_pose(), 4, 0.05, 1), hand_options(), diagnostics);
    ASSERT_TRUE(test::has_value(result));
    EXPECT_NEAR(result->errors.delay_s, late_s, 0.02);
    EXPECT_NEAR(result->errors.width_scale, 1 / 1.02, 0.01);
    EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), 1.2) << late_s;
    EXPECT_NE(decide(*result, {}, {{0, 0, 0}}).verdict(), Verdict::kAccept) << "not told";
  }
}

TEST(ErrorSolverTest, ErrorsThatAreRuledOutStayAtZero) {
  ImageRegistrationOptions solver = hand_options();
  solver.delay_sigma_s = 0;
  solver.calibration_sigma_mm = 0;
  CollectingDiagnostics diagnostics;
  const auto result =
      register_sweep(hand_ct(), uneven_sweep_late_by(0.08), test::true_pose(), solver, diagnostics);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_EQ(result->errors.delay_s, 0);
  EXPECT_EQ(result->error_deviations[0], 0);
  EXPECT_EQ(result->errors.shift_mm, Vec::Zero());
  EXPECT_GT(result->error_deviations[1], 0);
}

TEST(ErrorSolverTest, ADelayThatTheSweepDoesNotShowIsInThePredictedError) {
  // The probe moves straight on at 40 mm/s: what is not known of its delay is not known of the
  // pose.
  ImageRegistrationOptions solver = test::small_options(0);
  solver.calibration_sigma_mm = 0;
  solver.scale_sigma = solver.pressed_sigma_mm = 0;
  const auto predicted_mm = [&](double sigma_s) {
    solver.delay_sigma_s = sigma_s;
    CollectingDiagnostics diagnostics;
    const auto result = register_sweep(test::blob_scene().ct, test::blob_scene().sweep,
                                       test::true_pose(), solver, diagnostics);
    EXPECT_TRUE(test::has_value(result));
    return result->tre_rms_mm({{0, 0, 0}});
  };
  const double known = predicted_mm(0);
  const double little = predicted_mm(0.02);
  const double nothing = predicted_mm(0.2);
  EXPECT_LT(known, little);
  EXPECT_LT(little, nothing);
  EXPECT_GT(nothing, 1.5);
  EXPECT_LT(little, 1);
}

}  // namespace
}  // namespace nav::registration
