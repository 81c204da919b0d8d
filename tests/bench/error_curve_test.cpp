// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/error_curve.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace nav::bench {
namespace {

TEST(ErrorCurveTest, IsAStraightLineInLogarithms) {
  // The time is proportional to 1 / sqrt(rms), as for a second-order method.
  const ErrorCurve curve({{1e-2, 1}, {1e-4, 10}});
  EXPECT_NEAR(curve.time_at(1e-3), std::sqrt(10.0), 1e-12);
  EXPECT_DOUBLE_EQ(curve.time_at(1e-2), 1);
  EXPECT_DOUBLE_EQ(curve.time_at(1e-4), 10);
}

TEST(ErrorCurveTest, NeverExtrapolates) {
  const ErrorCurve curve({{1e-2, 1}, {1e-4, 10}});
  EXPECT_DOUBLE_EQ(curve.time_at(0.5), 1);
  EXPECT_TRUE(std::isnan(curve.time_at(9e-5)));
  EXPECT_FALSE(curve.spans(0.5));
  EXPECT_TRUE(curve.spans(3e-4));
  EXPECT_TRUE(std::isnan(ErrorCurve({}).time_at(1)));
}

TEST(ErrorCurveTest, LeavesOutPointsThatAreWorseInTimeAndError) {
  // A renderer whose error grows again with finer steps, and a point with an error of 0.
  const ErrorCurve curve({{2e-2, 2}, {3e-2, 1}, {2.5e-2, 4}, {0, 1}});
  ASSERT_EQ(curve.front().size(), 2U);
  EXPECT_DOUBLE_EQ(curve.front()[0].rms, 3e-2);
  EXPECT_DOUBLE_EQ(curve.front()[1].rms, 2e-2);
}

TEST(EqualErrorRatiosTest, CompareAtThePointsAndAtTheLevelsTheyReach) {
  const ErrorCurve ours({{1e-1, 1}, {1e-3, 4}});
  const ErrorCurve theirs({{1e-1, 10}, {1e-2, 30}, {5e-4, 90}});
  const auto ratios = equal_error_ratios(ours, theirs, {0.5, 1e-2, 1e-4});
  ASSERT_EQ(ratios.size(), 4U);  // Three points. Of the levels only 1e-2 lies on their curve.
  EXPECT_DOUBLE_EQ(ratios[0].ratio, 10);
  EXPECT_NEAR(ratios[1].ratio, 15, 1e-9);
  EXPECT_TRUE(std::isnan(ratios[2].ratio)) << "we end at 1e-3";
  EXPECT_NEAR(ratios[3].ratio, 15, 1e-9);
  EXPECT_DOUBLE_EQ(worst(ratios, {0, 1}), 0) << "an error that is not reached counts as 0";
  EXPECT_DOUBLE_EQ(worst(ratios, {1e-3, 1}), 10);
  EXPECT_DOUBLE_EQ(worst({{5e-2, 1}, {1e-2, 7}, {3e-3, 6}, {1e-3, 2}}), 6) << "of its range";
  EXPECT_DOUBLE_EQ(worst({{5e-2, 1}, {1e-3, 2}}), 1) << "nothing in its range: of all";
  EXPECT_TRUE(std::isnan(worst({})));
}

}  // namespace
}  // namespace nav::bench
