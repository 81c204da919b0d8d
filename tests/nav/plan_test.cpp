// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/plan.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav {
namespace {

constexpr double kPlanRounding = 1e-9;
const NeedlePlan kPlan{{{0, 0, 0}}, {{0, 0, 100}}, 10, 5};

Transform<frames::Ct, frames::Needle> needle(const Eigen::Vector3d& tip, double tilt_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitX())), tip};
}

TEST(GuidanceTest, OnThePathOnlyTheDepthRemains) {
  const auto guidance = guide(kPlan, needle({0, 0, 40}, 0));
  EXPECT_NEAR(guidance.tip_to_target_mm, 60, kPlanRounding);
  EXPECT_NEAR(guidance.along_axis_mm, 60, kPlanRounding);
  EXPECT_NEAR(guidance.lateral_mm, 0, kPlanRounding);
  EXPECT_NEAR(guidance.angle_to_plan_rad, 0, kPlanRounding);
}

TEST(GuidanceTest, DepthPastTheTargetIsNegative) {
  EXPECT_NEAR(guide(kPlan, needle({0, 0, 107}, 0)).along_axis_mm, -7, kPlanRounding);
}

TEST(GuidanceTest, LateralErrorOfATiltedNeedleIsTheSineOfTheTilt) {
  const auto guidance = guide(kPlan, needle({0, 0, 40}, 0.1));
  EXPECT_NEAR(guidance.lateral_mm, 60 * std::sin(0.1), kPlanRounding);
  EXPECT_NEAR(guidance.angle_to_plan_rad, 0.1, kPlanRounding);
}

TEST(NeedlePlanTest, RejectsInvalidPlans) {
  NeedlePlan plan = kPlan;
  EXPECT_TRUE(test::has_value(validate(plan)));
  plan.entry_ct = plan.target_ct;
  EXPECT_TRUE(test::rejects(validate(plan), ErrorCode::kMalformedData, {"1 mm apart"}));
  plan = kPlan;
  plan.target_ct.mm.x() = std::nan("");
  EXPECT_FALSE(validate(plan));
  plan = kPlan;
  plan.margin_mm = -1;
  EXPECT_FALSE(validate(plan));
}

}  // namespace
}  // namespace nav
