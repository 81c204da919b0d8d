// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/histogram.hpp"

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

PredicateHistogram bars(std::vector<double> importances) {
  std::vector<PredicateHistogram::Bar> out;
  for (const double k : importances) out.push_back({k, 0, 0});
  return *PredicateHistogram::create(std::move(out));
}

double sum_of(const PredicateHistogram& histogram) {
  double sum = 0;
  for (const auto& bar : histogram.bars()) sum += bar.importance;
  return sum;
}

TEST(PredicateHistogramTest, TheSumStaysOneAfterAMillionRandomEdits) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  PredicateHistogram histogram = bars({1, 2, 3});
  double worst = 0;
  for (int edit = 0; edit < 1'000'000; ++edit) {
    const double kind = unit(random);
    const auto bar = static_cast<std::size_t>(unit(random) * static_cast<double>(histogram.size()));
    if (kind < 0.02 && histogram.size() < kMostPredicates) {
      histogram.add(360 * unit(random), unit(random));
    } else if (kind < 0.04 && histogram.size() > 1) {
      histogram.remove(bar);
    } else if (kind < 0.06) {
      std::vector<std::uint64_t> shown(histogram.size());
      std::vector<std::uint64_t> hidden(histogram.size());
      for (auto& n : shown) n = random() % 1000;
      for (auto& n : hidden) n = random() % 1000;
      histogram.scribble(shown, hidden, unit(random));
    } else {
      // Often to the ends, and by tiny amounts.
      const double to = kind < 0.2   ? std::round(unit(random))
                        : kind < 0.3 ? 1e-300 * unit(random)
                                     : unit(random);
      histogram.drag(bar, to);
    }
    worst = std::max(worst, std::abs(sum_of(histogram) - 1));
    for (const auto& b : histogram.bars()) ASSERT_TRUE(b.importance >= 0 && b.importance <= 1);
  }
  EXPECT_LT(worst, PredicateHistogram::kSumTolerance);
}

TEST(PredicateHistogramTest, ADragKeepsTheProportionsOfTheOthers) {
  PredicateHistogram histogram = bars({1, 2, 3, 4});
  histogram.drag(3, 0.7);
  EXPECT_NEAR(histogram.bars()[0].importance, 0.05, 1e-15);
  EXPECT_NEAR(histogram.bars()[1].importance, 0.10, 1e-15);
  EXPECT_NEAR(histogram.bars()[2].importance, 0.15, 1e-15);
  EXPECT_NEAR(histogram.bars()[3].importance, 0.70, 1e-15);
}

TEST(PredicateHistogramTest, ADragFromOneSharesEquallyIfAllOthersAreZero) {
  PredicateHistogram histogram = bars({0, 1, 0});
  histogram.drag(1, 0.5);
  EXPECT_EQ(histogram.bars()[0].importance, 0.25);
  EXPECT_EQ(histogram.bars()[2].importance, 0.25);
  histogram.drag(0, std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(histogram.bars()[0].importance, 0.25) << "NaN moves nothing";
}

TEST(PredicateHistogramTest, ASingleBarStaysAtOne) {
  PredicateHistogram histogram = bars({5});
  histogram.drag(0, 0.2);
  EXPECT_EQ(histogram.bars()[0].importance, 1);
}

TEST(PredicateHistogramTest, ScribblesRaiseShownAndLowerHiddenPredicates) {
  PredicateHistogram histogram = bars({1, 1, 1, 1});
  // m = q (N+ - N-) / sum |N+ - N-|, minus the mean. Here (60, -20, 20, 0) / 100, with a mean of
  // 0.15.
  const std::uint64_t shown[] = {60, 0, 30, 5};
  const std::uint64_t hidden[] = {0, 20, 10, 5};
  histogram.scribble(shown, hidden, 0.25);
  EXPECT_NEAR(histogram.bars()[0].importance, 0.25 + 0.25 * (0.6 - 0.15), 1e-15);
  EXPECT_NEAR(histogram.bars()[1].importance, 0.25 + 0.25 * (-0.2 - 0.15), 1e-15);
  EXPECT_NEAR(histogram.bars()[2].importance, 0.25 + 0.25 * (0.2 - 0.15), 1e-15);
  EXPECT_NEAR(histogram.bars()[3].importance, 0.25 + 0.25 * (0 - 0.15), 1e-15);
}

TEST(PredicateHistogramTest, ScribblesThatMainlyHideDoNotInvertTheEffect) {
  PredicateHistogram histogram = bars({1, 1});
  const std::uint64_t shown[] = {0, 10};
  const std::uint64_t hidden[] = {100, 10};
  histogram.scribble(shown, hidden);  // The printed denominator is negative here.
  EXPECT_LT(histogram.bars()[0].importance, 0.5);
  EXPECT_GT(histogram.bars()[1].importance, 0.5);
}

TEST(PredicateHistogramTest, BalancedAndEmptyScribblesChangeNothing) {
  PredicateHistogram histogram = bars({1, 2, 5});
  const auto before = histogram.bars();
  const std::uint64_t some[] = {3, 0, 9};
  const std::uint64_t none[] = {0, 0, 0};
  histogram.scribble(some, some);
  histogram.scribble(none, none);
  EXPECT_EQ(histogram.bars(), before);
}

TEST(PredicateHistogramTest, ScribblesKeepImportancesNonNegative) {
  PredicateHistogram histogram = bars({0.01, 0.01, 0.98});
  const std::uint64_t shown[] = {0, 0, 0};
  const std::uint64_t hidden[] = {100, 1, 0};
  histogram.scribble(shown, hidden, 1.0);
  EXPECT_EQ(histogram.bars()[0].importance, 0);
  EXPECT_NEAR(sum_of(histogram), 1, 1e-15);
}

TEST(PredicateHistogramTest, ADeficitBelowZeroIsSharedEquallyByTheOthers) {
  // m = (-70, 0, 30) / 100, minus the mean of -40 / 300: (-0.5667, 0.1333, 0.4333).
  const std::uint64_t shown[] = {0, 0, 30};
  const std::uint64_t hidden[] = {70, 0, 0};
  PredicateHistogram histogram = bars({0.1, 0.2, 0.7});
  histogram.scribble(shown, hidden, 1);  // 0.4667 are missing: 0.2333 from each of the two others.
  EXPECT_EQ(histogram.bars()[0].importance, 0);
  EXPECT_NEAR(histogram.bars()[1].importance, 0.1, 1e-15);
  EXPECT_NEAR(histogram.bars()[2].importance, 0.9, 1e-15);
  histogram = bars({0.1, 0.05, 0.85});
  histogram.scribble(shown, hidden, 1);  // The second bar then lacks 0.05.
  EXPECT_EQ(histogram.bars()[0].importance, 0);
  EXPECT_EQ(histogram.bars()[1].importance, 0);
  EXPECT_NEAR(histogram.bars()[2].importance, 1, 1e-15);
}

TEST(PredicateHistogramTest, ANewBarHasTheMeanHeight) {
  PredicateHistogram histogram = bars({1, 3});
  histogram.add(0, 0);  // 1/4, 3/4 and their mean add up to 3/2.
  EXPECT_NEAR(histogram.bars()[0].importance, 1.0 / 6, 1e-15);
  EXPECT_NEAR(histogram.bars()[1].importance, 3.0 / 6, 1e-15);
  EXPECT_NEAR(histogram.bars()[2].importance, 2.0 / 6, 1e-15);
}

TEST(PredicateHistogramTest, HuesAreReducedToOneTurn) {
  PredicateHistogram histogram = *PredicateHistogram::create({{1, -30, 0.5}, {1, 725, 1}});
  EXPECT_EQ(histogram.bars()[0].hue_deg, 330);
  EXPECT_EQ(histogram.bars()[1].hue_deg, 5);
  histogram.set_colour(0, -1e-20, 2);
  EXPECT_LT(histogram.bars()[0].hue_deg, 360);
  EXPECT_EQ(histogram.bars()[0].saturation, 1);
}

TEST(PredicateHistogramTest, RejectsBarsThatCannotBeNormalised) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using test::rejects;
  const auto code = ErrorCode::kMalformedData;
  EXPECT_TRUE(rejects(PredicateHistogram::create({{1, 0, 0}, {-0.1, 0, 0}}), code,
                      {"predicate 1", "importance >= 0", "-0.1"}));
  EXPECT_TRUE(rejects(PredicateHistogram::create({{nan, 0, 0}}), code, {"predicate 0"}));
  EXPECT_TRUE(rejects(PredicateHistogram::create({{1, nan, 0}}), code, {"hue"}));
  EXPECT_TRUE(rejects(PredicateHistogram::create({{1, 0, 1.5}}), code, {"saturation", "1.5"}));
  EXPECT_TRUE(rejects(PredicateHistogram::create(std::vector<PredicateHistogram::Bar>(33)), code,
                      {"at most 32", "33"}));
}

}  // namespace
}  // namespace nav::render
