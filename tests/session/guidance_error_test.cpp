// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/guidance_error.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace nav::session {
namespace {

using Vec3 = Eigen::Vector3d;
using ::testing::Contains;

const NeedlePlan kPlan{{{10, -80, 20}}, {{0, 0, 0}}, 5, 0};
constexpr double kInterval = 1.959964;

/// A needle whose tip is 40 mm before the target and 6 mm beside it.
Transform<frames::Ct, frames::Needle> needle_beside() {
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), Vec3(0.05, 1, -0.1).normalized());
  return {turn, Vec3(6, -40, 3)};
}

registration::PoseUncertainty some_uncertainty() {
  Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Zero();
  root.diagonal() << 0.004, 0.006, 0.003, 0.5, 0.3, 0.8;
  root(3, 1) = 0.1;
  root(5, 0) = -0.2;
  return {{{20, 10, -30}}, root * root.transpose()};
}

TEST(GuidanceErrorTest, AShiftOfTheRegistrationShiftsTheTip) {
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  covariance(4, 4) = 4;  // 2 mm along y.
  const Transform<frames::Ct, frames::Needle> needle(
      Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitY()), Vec3(0, -50, 0));
  const NeedlePlan plan{{{0, -100, 0}}, {{0, 0, 0}}, 5, 0};
  const GuidanceError error = guidance_error(
      plan, needle, {.registration = registration::PoseUncertainty{{Vec3::Zero()}, covariance}});
  EXPECT_NEAR(*error.tip_to_target_mm, 2 * kInterval, 1e-9);
  EXPECT_NEAR(*error.along_axis_mm, 2 * kInterval, 1e-9);
  EXPECT_NEAR(*error.lateral_mm, 0, 1e-9) << "the shift is along the needle";
  EXPECT_NEAR(*error.angle_to_plan_rad, 0, 1e-9);
}

/// Truth: maps that the uncertainty describes, drawn at random.
TEST(GuidanceErrorTest, IntervalsHoldTheTrueNumbersWith95Percent) {
  const auto uncertainty = some_uncertainty();
  constexpr double kTrackerRms = 0.6;
  const auto needle = needle_beside();
  const GuidanceError error =
      guidance_error(kPlan, needle, {.registration = uncertainty, .tracker_rms_mm = kTrackerRms});
  const NeedleGuidance shown = guide(kPlan, needle);
  const Eigen::Matrix<double, 6, 6> root = uncertainty.covariance.llt().matrixL();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 4000;
  std::array<int, 4> held{};
  for (int i = 0; i < kDraws; ++i) {
    Eigen::Matrix<double, 6, 1> twist;
    for (double& x : twist) x = normal(random);
    twist = root * twist;
    const Vec3 turn = twist.head<3>();
    const Eigen::Quaterniond q(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
    const Vec3 centre = uncertainty.centre_ct.mm;
    Vec3 tip = centre + q * (needle.translation_mm() - centre) + twist.tail<3>();
    tip += kTrackerRms / std::sqrt(3.0) * Vec3(normal(random), normal(random), normal(random));
    const NeedleGuidance truth = guide(kPlan, {q * needle.rotation(), tip});
    const auto count = [&](std::size_t n, double a, double b, double half) {
      if (std::abs(a - b) <= half) ++held[n];
    };
    count(0, truth.tip_to_target_mm, shown.tip_to_target_mm, *error.tip_to_target_mm);
    count(1, truth.along_axis_mm, shown.along_axis_mm, *error.along_axis_mm);
    count(2, truth.lateral_mm, shown.lateral_mm, *error.lateral_mm);
    count(3, truth.angle_to_plan_rad, shown.angle_to_plan_rad, *error.angle_to_plan_rad);
  }
  // Three standard deviations of a share of 0.95 of 4000 draws are 0.010.
  for (const int one : held) EXPECT_NEAR(1.0 * one / kDraws, 0.95, 0.012) << one;
}

TEST(GuidanceErrorTest, AtTheTargetTheLargestErrorOfAllDirectionsCounts) {
  const Transform<frames::Ct, frames::Needle> needle(
      Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), -kPlan.entry_ct.mm.normalized()),
      Vec3::Zero());
  const GuidanceError error = guidance_error(kPlan, needle, {.tracker_rms_mm = 0.6});
  EXPECT_NEAR(*error.tip_to_target_mm, kInterval * 0.6 / std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(*error.lateral_mm, kInterval * 0.6 / std::sqrt(3.0), 1e-9);
  EXPECT_FALSE(error.angle_to_plan_rad) << "nothing is known about the direction";
}

TEST(GuidanceErrorTest, SaysWhichErrorsAreInItAndWhichAreNot) {
  const GuidanceError none = guidance_error(kPlan, needle_beside(), {});
  EXPECT_FALSE(none.tip_to_target_mm || none.along_axis_mm || none.lateral_mm ||
               none.angle_to_plan_rad);
  EXPECT_TRUE(none.with.empty());
  EXPECT_THAT(none.without, Contains("registration"));
  const GuidanceError registered =
      guidance_error(kPlan, needle_beside(), {.registration = some_uncertainty()});
  EXPECT_THAT(registered.with, Contains("registration"));
  EXPECT_THAT(registered.without, Contains("tracker, position of the tip"));
  EXPECT_THAT(registered.without, Contains("bending of the needle"));
}

}  // namespace
}  // namespace nav::session
