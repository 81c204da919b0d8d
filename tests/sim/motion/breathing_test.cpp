// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/breathing.hpp"

#include <gmock/gmock.h>
#include <numbers>

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using ::testing::HasSubstr;

Timestamp at(double seconds) { return Timestamp(from_seconds(seconds)); }

BreathingOptions options_of(BreathingKind kind) {
  BreathingOptions options;
  options.kind = kind;
  return options;
}

BreathingOptions regular(BreathingKind kind) {
  BreathingOptions options = options_of(kind);
  options.period_variation = 0;
  options.amplitude_variation = 0;
  return options;
}

TEST(BreathingTest, DepthOfRegularBreathingFollowsTheClosedForm) {
  const Breathing breathing(regular(BreathingKind::kSmooth));
  for (double s = 0; s < 12; s += 0.13) {
    const double expected = std::pow(std::sin(std::numbers::pi * s / 4), 4);
    EXPECT_NEAR(breathing.state(at(s)).depth, expected, 1e-9);
  }
}

TEST(BreathingTest, MovesTheCentreByItsAmplitudeAtFullDepth) {
  for (const auto kind : {BreathingKind::kRigid, BreathingKind::kAffine, BreathingKind::kSmooth}) {
    BreathingOptions options = regular(kind);
    options.lag_s = 0;
    const Breathing breathing(options);
    const auto warp = breathing.warp(at(2));
    EXPECT_LE((warp->apply(options.centre_mm) - options.centre_mm - options.amplitude_mm).norm(),
              1e-6)
        << to_string(kind);
    const auto rest = breathing.warp(at(8));
    EXPECT_LE((rest->apply(Vec(-20, 30, 5)) - Vec(-20, 30, 5)).norm(), 1e-9);
  }
}

TEST(BreathingTest, LagGivesDifferentPathsInAndOut) {
  const Breathing breathing(regular(BreathingKind::kSmooth));
  // The depth is equal on the way in and on the way out, but the displacement to the front differs.
  const auto in = breathing.state(at(1.2));
  const auto out = breathing.state(at(2.8));
  EXPECT_NEAR(in.depth, out.depth, 1e-9);
  EXPECT_LT(in.lagging_depth, in.depth - 0.05);
  EXPECT_GT(out.lagging_depth, out.depth + 0.05);
}

TEST(BreathingTest, IrregularBreathsAreContinuousAndDiffer) {
  BreathingOptions options = options_of(BreathingKind::kRigid);
  options.period_variation = 0.5;
  options.amplitude_variation = 0.5;
  const Breathing breathing(options);
  double least = 9, most = 0;
  double before = breathing.state(at(-20)).depth;
  std::int64_t cycle = breathing.state(at(-20)).cycle;
  double peak = 0;
  for (double s = -20 + 1e-3; s < 60; s += 1e-3) {
    const auto now = breathing.state(at(s));
    ASSERT_GE(now.phase, 0);
    ASSERT_LT(now.phase, 1);
    // Steepest slope: 1.5 · π · 4 sin³ cos / (shortest cycle of 2 s) = 3.1 per second.
    ASSERT_NEAR(now.depth, before, 3.2e-3) << s;
    ASSERT_TRUE(now.cycle == cycle || now.cycle == cycle + 1);
    if (now.cycle != cycle) {
      least = std::min(least, peak);
      most = std::max(most, peak);
      peak = 0;
      cycle = now.cycle;
    }
    peak = std::max(peak, now.depth);
    before = now.depth;
  }
  EXPECT_LT(least, 0.8);
  EXPECT_GT(most, 1.2);
}

TEST(BreathingTest, ResultDependsOnTheSeedButNotOnTheOrderOfQueries) {
  BreathingOptions options = options_of(BreathingKind::kSmooth);
  const Breathing a(options), b(options);
  const double late = a.state(at(33.3)).depth;
  EXPECT_GT(a.state(at(1)).depth, 0);
  EXPECT_EQ(b.state(at(33.3)).depth, late);
  options.seed = 2;
  EXPECT_NE(Breathing(options).state(at(33.3)).depth, late);
}

TEST(BreathingTest, WithoutBreathingNothingMoves) {
  const Breathing breathing(BreathingOptions{});
  EXPECT_EQ(breathing.warp(at(1.7))->apply({1, 2, 3}), Vec(1, 2, 3));
}

TEST(BreathingTest, RejectsInvalidOptions) {
  BreathingOptions folding = options_of(BreathingKind::kSmooth);
  folding.extent_mm = {20, 20, 20};
  folding.amplitude_mm = {0, 0, -40};
  ASSERT_FALSE(validate(folding));
  EXPECT_THAT(validate(folding).error().message, HasSubstr("fold"));
  BreathingOptions nan = options_of(BreathingKind::kRigid);
  nan.period_s = std::nan("");
  EXPECT_FALSE(validate(nan));
  nan = options_of(BreathingKind::kRigid);
  nan.amplitude_mm.y() = std::nan("");
  EXPECT_FALSE(validate(nan));
  EXPECT_FALSE(breathing_kind_from("deep"));
  EXPECT_EQ(*breathing_kind_from("affine"), BreathingKind::kAffine);
}

}  // namespace
}  // namespace nav::sim
