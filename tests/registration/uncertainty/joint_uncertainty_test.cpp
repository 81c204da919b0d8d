// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/uncertainty/joint_uncertainty.hpp"

#include <gtest/gtest.h>

#include "registration/prepared.hpp"
#include "tests/registration/uneven_hand.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

TEST(JointUncertaintyTest, AnErrorThatIsHeldIsInThePredictedError) {
  constexpr double kLateS = 0.1;      // Moves the pose by some millimetres if it is left out.
  constexpr double kMostRatio = 1.5;  // One Newton step is not exact.
  const ErrorSigmas delay_only{.delay_s = 0.2, .depth_scale = 0, .width_scale = 0};
  const ImageRegistrationOptions options = test::hand_options();
  CollectingDiagnostics diagnostics;
  const auto sweep =
      PreparedSweep::create(test::uneven_sweep_late_by(kLateS), options, diagnostics);
  const auto ct = PreparedCt::create(test::hand_ct(), options);
  ASSERT_TRUE(test::has_value(sweep));
  ASSERT_TRUE(test::has_value(ct));
  const PatchSet& recorded = sweep->levels().back().patches;
  const SimilarityCost cost(*ct->levels().back(), recorded, options.ridge, 1);
  const Point<frames::Reference>& centroid = sweep->points().centroid;
  const SolveLimits limits{.max_iterations = 30, .cost_tolerance = 1e-6};
  const auto keep_going = [] { return true; };

  const PoseSolution held = solve_pose(cost, test::true_pose(), centroid, limits, keep_going);
  const ErrorSolution together = solve_errors(cost, held.pose, {}, centroid, delay_only,
                                              sweep->motions(), sweep->path(), limits, keep_going);
  ASSERT_NEAR(together.errors.delay_s, kLateS, 0.02);
  const auto predicted_mm = [&](const Pose& pose, const ImageErrors& errors) {
    const PatchSet patches = corrected(recorded, errors, sweep->motions(), sweep->path());
    const LocalShape shape = local_shape(cost.on(patches), pose, pose * centroid, 0.8);
    const JointCovariance joint = joint_covariance(shape, recorded, errors, pose, delay_only,
                                                   sweep->motions(), sweep->path(), 0.07);
    EXPECT_TRUE(joint.pose.valid) << joint.pose.fault;
    return joint.pose.uncertainty.tre_rms_mm(pose * centroid);
  };
  const double apart_mm = (held.pose * centroid - together.pose.pose * centroid).v.norm();
  ASSERT_GT(apart_mm, 0.5);
  const double held_mm = predicted_mm(held.pose, {});
  EXPECT_GT(held_mm, apart_mm / kMostRatio);
  EXPECT_LT(held_mm, apart_mm * kMostRatio);
  EXPECT_LT(predicted_mm(together.pose.pose, together.errors), 0.5 * held_mm);
}

}  // namespace
}  // namespace nav::registration
