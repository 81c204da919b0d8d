// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <gtest/gtest.h>

#include "bench/registration/hopeless.hpp"
#include "bench/registration/summary.hpp"

namespace nav::bench {
namespace {

Trial trial(bool global, double start_mm, double error_mm, bool accepted) {
  Trial t;
  t.global = global;
  t.start_mm = start_mm;
  t.solved = true;
  t.error_mm = error_mm;
  t.accepted = accepted;
  t.covered = 0.9;
  return t;
}

TEST(CohortSummaryTest, CountsPlantedTrials) {
  CohortResult result;
  result.trials = {trial(false, 5, 0.2, true), trial(false, 10, 9.0, false),
                   trial(true, 40, 0.4, true), trial(true, 40, 1.5, false),
                   trial(true, 20, 3.5, true), trial(true, 60, 0.1, true),
                   trial(true, 5, 0.3, true)};
  result.trials.back().hopeless = Hopeless::kTurned;
  Trial wrong = trial(true, 5, 0.3, true);
  wrong.hopeless = Hopeless::kWrongPatient;
  wrong.acceptable = false;
  result.trials.push_back(wrong);
  result.trials[4].warned = true;
  const CohortSummary s = summarise(result);
  EXPECT_EQ(s.trials, 8);
  EXPECT_EQ(s.accepted, 3);  // 0.2, 0.4, 3.5.
  EXPECT_EQ(s.warned, 1);
  EXPECT_DOUBLE_EQ(s.clear_p95_mm, 0.4);
  EXPECT_DOUBLE_EQ(s.warned_median_mm, 3.5);
  EXPECT_EQ(s.right, 3);  // 0.2, 0.4, 1.5; 60 mm and the hopeless do not count.
  EXPECT_DOUBLE_EQ(s.tre_median_mm, 0.4);
  EXPECT_DOUBLE_EQ(s.success_local_10mm, 0.5);
  EXPECT_DOUBLE_EQ(s.success_from_40mm, 2.0 / 3.0);
  EXPECT_EQ(s.false_accepts, 2);  // 3.5 mm, and the other patient whatever its error.
  EXPECT_EQ(s.false_refusals, 1);
  EXPECT_DOUBLE_EQ(s.hopeless_refused, 0.5);
  EXPECT_DOUBLE_EQ(s.coverage_95, 0.9);
}

TEST(CohortSummaryTest, ABoundOfNoneInNIsTheRuleOfThree) {
  // Exactly 1 - 0.05^(1/n).
  EXPECT_NEAR(share_bound_95(0, 1000), 1 - std::pow(0.05, 1e-3), 1e-9);
  EXPECT_GT(share_bound_95(1, 1000), share_bound_95(0, 1000));
  EXPECT_EQ(share_bound_95(3, 3), 1);
}

TEST(CohortSummaryTest, QuantilesAreNearestRanks) {
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(quantile({3, 1, 2}, 1.0), 3);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(CohortTest, StartsHaveTheErrorThatTheyClaim) {
  const CtPose truth(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX())),
                     {10, -20, 30});
  std::vector<TrackedFrame> frames(
      1, TrackedFrame{{}, {Eigen::Quaterniond::Identity(), {0, 0, 0}}, Duration{0}});
  frames[0].frame.pixels = Image2d<std::uint8_t>(2, 2, {1, 2, 3, 4});
  frames[0].frame.grid = PixelGrid::centred(2, 1, 1);
  RecordedSweep recorded{SweepPath::kFan, *Sweep::create(std::move(frames), "one"), {}};
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3d p(30.0 * (i % 3 - 1), 30.0 * (i / 3 % 3 - 1), 30.0 * (i / 9 - 1));
    recorded.targets.push_back(truth * Point<frames::Reference>{p});
  }
  for (const double mm : {5.0, 20.0, 60.0}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const CtPose start = start_at(mm, truth, recorded, seed);
      EXPECT_NEAR(target_error_mm(start, truth, recorded.targets), mm, 1e-6);
      EXPECT_LE(rotation_distance_rad(start, truth), 30 * M_PI / 180 + 1e-9);
    }
  }
}

}  // namespace
}  // namespace nav::bench
