// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/live_budget.hpp"

#include <gtest/gtest.h>

namespace nav::app {
namespace {

Timestamp at(double seconds) { return Timestamp(from_seconds(seconds)); }

/// Moments at a distance, each drawn with this much time besides its rays.
LiveBudget after(double interval_s, double besides_s, std::uint64_t step = 1) {
  LiveBudget budget;
  for (std::uint64_t i = 0; i < 100; ++i) {
    budget.ordered(1 + step * i, at(interval_s * static_cast<double>(step * i)));
    budget.drawn(0.02, 0.02 + besides_s);
  }
  return budget;
}

TEST(LiveBudgetTest, IsWhatRemainsOfTheTimeBetweenTwoMoments) {
  constexpr double kTolerance = 1e-4;  // s; a mean over many images.
  EXPECT_EQ(LiveBudget().budget_s(), LiveBudget::kFirst);
  EXPECT_NEAR(after(1.0 / 30, 0.005).budget_s(), 0.9 / 30 - 0.005, kTolerance);
  EXPECT_NEAR(after(1.0 / 30, 0.005, 3).budget_s(), 0.9 / 30 - 0.005, kTolerance)
      << "moments were left out";
  EXPECT_EQ(after(1.0 / 30, 0.1).budget_s(), LiveBudget::kLeast);
  EXPECT_EQ(after(1.0 / 5, 0.005).budget_s(), LiveBudget::kMost);
}

TEST(LiveBudgetTest, PausesAndNewSessionsDoNotCount) {
  LiveBudget budget = after(1.0 / 30, 0);
  const double before = budget.budget_s();
  budget.ordered(1000, at(5000));
  budget.ordered(1000, at(5000));
  budget.ordered(1, at(5001));
  EXPECT_EQ(budget.budget_s(), before);
}

}  // namespace
}  // namespace nav::app
