// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/transfer_table.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "render/rounding.hpp"

namespace nav::render {
namespace {

/// The table stores entries in single precision.
constexpr double kTableRounding = 1e-6;
constexpr double kEndless = std::numeric_limits<double>::infinity();

TransferComponent random_component(std::mt19937& random, bool whole) {
  std::uniform_real_distribution<double> unit(0, 1);
  TransferComponent component{"random", {}, {}};
  double hu = -200 * unit(random);
  const int count = 2 + static_cast<int>(6 * unit(random));
  for (int i = 0; i < count; ++i) {
    const double opacity = unit(random) < 0.6 ? 0 : 0.9 * unit(random);
    component.nodes.push_back({whole ? std::round(hu) : hu,
                               {unit(random), unit(random), unit(random)},
                               opacity,
                               unit(random)});
    hu += 2 + 60 * unit(random);
  }
  return component;
}

TransferFunction random_function(std::mt19937& random, bool whole) {
  return *TransferFunction::create("random", random_component(random, whole).nodes);
}

/// Colour times extinction, and extinction, linear between entries by definition.
Eigen::Vector4d premultiplied(const TransferTable& table, double hu) {
  const double x = std::clamp(hu - table.first_hu(), 0.0, table.size() - 1.0);
  const auto i = std::min(static_cast<std::size_t>(x), static_cast<std::size_t>(table.size()) - 2);
  const auto entry = [&](std::size_t e) {
    Eigen::Vector4d v =
        Eigen::Map<const Eigen::Vector4f>(table.rgbat().data() + 4 * e).cast<double>();
    v.head<3>() *= v[3];
    return v;
  };
  const double w = x - static_cast<double>(i);
  return (1 - w) * entry(i) + w * entry(i + 1);
}

/// The mean over [a, b] by the midpoint rule between whole values, where it is exact.
Eigen::Vector4d dense_mean(const TransferTable& table, double a, double b) {
  const auto [low, high] = std::minmax(a, b);
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (double from = low; from < high;) {
    const double to = std::min(high, std::floor(from) + 1);
    sum += (to - from) * premultiplied(table, 0.5 * (from + to));
    from = to;
  }
  return sum / (high - low);
}

void expect_mean(const TransferTable& table, double a, double b) {
  const Eigen::Vector4d expected = dense_mean(table, a, b);
  const TransferSample found = table.mean(a, b);
  // The function subtracts integrals of some hundred HU.
  const double tolerance = 1e-11 * (1 + 100 / std::abs(b - a));
  EXPECT_NEAR(found.tau_per_mm, expected[3], tolerance) << a << ' ' << b;
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(found.rgb[c] * found.tau_per_mm, expected[c], tolerance) << a << ' ' << b;
  }
}

TEST(TransferTableTest, ABowShiftsTheMeanOfALinearFunctionByTheBow) {
  const TransferTable table(*TransferFunction::create(
      "ramp", {{0, {1, 1, 1}, 0, 1}, {1000, {1, 1, 1}, -std::expm1(-1.0), 1}}));
  for (const auto& [a, b] : {std::pair{200.0, 600.0}, {600.0, 200.0}, {300.0, 340.0}}) {
    for (const double bow : {-20.0, -3.0, 0.0, 7.0, 20.0}) {
      const TransferSample there = table.mean(a, b, bow);
      EXPECT_NEAR(there.tau_per_mm, table.at(0.5 * (a + b) + bow).tau_per_mm, 1e-5)
          << a << ' ' << b << ' ' << bow;
      EXPECT_EQ(there.tau_per_mm, table.mean(b, a, bow).tau_per_mm);
    }
    // A bow above half of the change is limited to half of it.
    EXPECT_EQ(table.mean(a, b, 1e6).tau_per_mm, table.mean(a, b, 0.5 * std::abs(b - a)).tau_per_mm);
  }
}

TEST(TransferTableTest, ABowBetweenInvisibleEndsShowsNothingAndIsNeverNegative) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const TransferTable table(random_function(random, i % 2 == 0));
    for (int j = 0; j < 50; ++j) {
      const double a = 200 * unit(random);
      const double b = 200 * unit(random);
      const double bow = 100 * unit(random);
      const TransferSample found = table.mean(a, b, bow);
      EXPECT_GE(found.tau_per_mm, 0);
      EXPECT_TRUE((found.rgb.array() >= 0).all() && (found.rgb.array() <= 1).all());
      if (table.visible(std::min(a, b), std::max(a, b))) continue;
      EXPECT_EQ(found.tau_per_mm, 0);
    }
  }
}

bool is_visible(const TransferFunction& function, double hu) {
  return static_cast<float>(function.at(hu).tau_per_mm) > 0;
}

/// The importance of the nearest visible whole value, the lower one of two. 0 if there is none.
double entry_importance(const TransferFunction& function, const TransferTable& table, double hu) {
  for (double away = 0; away <= table.last_hu() - table.first_hu(); ++away) {
    for (const double at : {hu - away, hu + away}) {
      const bool within = at >= table.first_hu() && at <= table.last_hu();
      if (within && is_visible(function, at)) return function.at(at).importance;
    }
  }
  return 0;
}

TEST(TransferTableTest, IsExactForNodesAtWholeHu) {
  std::mt19937 random(1);
  for (int f = 0; f < 20; ++f) {
    const TransferFunction function = random_function(random, true);
    const TransferTable table(function);
    EXPECT_EQ(table.rows(), 1);
    EXPECT_EQ(table.first_hu(), function.values().front());
    EXPECT_EQ(table.last_hu(), function.values().back());
    for (double hu = table.first_hu() - 3; hu < table.last_hu() + 3; hu += 0.25) {
      EXPECT_NEAR(table.at(hu).tau_per_mm, function.at(hu).tau_per_mm, kTableRounding) << hu;
      EXPECT_NEAR((table.at(hu).rgb - function.at(hu).rgb).norm(), 0, kTableRounding) << hu;
    }
    for (double hu = table.first_hu(); hu <= table.last_hu(); ++hu) {
      EXPECT_NEAR(table.at(hu).importance, entry_importance(function, table, hu), kTableRounding)
          << hu;
    }
  }
}

TEST(TransferTableTest, ImportanceComesFromTheNearestEntry) {
  const TransferTable table(*TransferFunction::create(
      "jump", {{0, {1, 1, 1}, 0.5, 0.25}, {1, {1, 1, 1}, 0.5, 0.75}, {2, {1, 1, 1}, 0, 1}}));
  EXPECT_EQ(table.at(0.49).importance, 0.25);
  EXPECT_EQ(table.at(0.5).importance, 0.75);
  EXPECT_EQ(table.at(1.49).importance, 0.75);
  EXPECT_EQ(table.at(1.5).importance, 0.75) << "an invisible entry: of the nearest visible one";
  EXPECT_EQ(table.at(-100).importance, 0.25);
  EXPECT_TRUE(table.importance_matters());
}

TEST(TransferTableTest, ImportanceMattersOnlyIfAValueIsVisible) {
  const auto matters = [](double opacity, double importance) {
    return TransferTable(*TransferFunction::create("one", {{0, {1, 1, 1}, opacity, importance},
                                                           {9, {1, 1, 1}, opacity, importance}}))
        .importance_matters();
  };
  EXPECT_FALSE(matters(0.5, 1));
  EXPECT_FALSE(matters(0, 0.5));
  EXPECT_TRUE(matters(1e-9, 0.9));
}

TEST(TransferTableTest, MeanEqualsDenseIntegration) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> anywhere(-300, 500);
  std::uniform_real_distribution<double> near(-3, 3);
  for (int f = 0; f < 40; ++f) {
    const TransferTable table(random_function(random, f % 2 == 0));
    for (int trial = 0; trial < 50; ++trial) {
      const double a = anywhere(random);
      expect_mean(table, a, anywhere(random));
      const double b = a + near(random);
      if (std::abs(b - a) > 0.01) expect_mean(table, a, b);
    }
    expect_mean(table, -1e4, 1e4);
    expect_mean(table, 1000, 2000);
  }
}

TEST(TransferTableTest, MeanIsSymmetricAndEqualsTheValueIfTheEndsAreEqual) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-250, 300);
  for (int f = 0; f < 40; ++f) {
    const TransferTable table(random_function(random, false));
    const double a = anywhere(random);
    const double b = anywhere(random);
    EXPECT_NEAR(table.mean(a, b).tau_per_mm, table.mean(b, a).tau_per_mm, 1e-15);
    // The limit of equal ends, from both sides of the switch to the value itself.
    for (const double gap : {0.0, 1e-9, 0.0009, 0.0011, 0.01}) {
      const TransferSample at = table.at(a);
      const TransferSample mean = table.mean(a, a + gap);
      constexpr double kSteepest = 2.4;  // The steepest extinction per HU: opacity 0.9 within one
                                         // HU.
      EXPECT_NEAR(mean.tau_per_mm, at.tau_per_mm, 1e-8 + gap * kSteepest) << gap;
    }
  }
}

TEST(TransferTableTest, SpikesAndStepsOfOneHuKeepTheirArea) {
  const double tau = -std::log1p(-0.5);
  const Eigen::Vector3d red(1, 0, 0);
  const TransferTable spike(
      *TransferFunction::create("spike", {{99, red, 0, 1}, {100, red, 0.5, 1}, {101, red, 0, 1}}));
  EXPECT_NEAR(spike.mean(0, 200).tau_per_mm, tau / 200, 1e-9);
  EXPECT_NEAR(spike.mean(90, 100).tau_per_mm, tau / 2 / 10, 1e-8);
  EXPECT_NEAR((spike.mean(0, 200).rgb - red).norm(), 0, kTableRounding);
  EXPECT_EQ(spike.mean(0, 99).tau_per_mm, 0);
  EXPECT_EQ(spike.mean(101, 500).tau_per_mm, 0);
  const TransferTable step(
      *TransferFunction::create("step", {{99, red, 0, 1}, {100, red, 0.5, 1}}));
  EXPECT_NEAR(step.mean(0, 200).tau_per_mm, tau * 100.5 / 200, 1e-7);
  EXPECT_NEAR(step.mean(100, 4000).tau_per_mm, tau, 1e-7);
}

TEST(TransferTableTest, IntegralsAreWholeQuantaOfTheExactIntegral) {
  std::mt19937 random(6);
  for (int f = 0; f < 20; ++f) {
    const TransferTable table(random_function(random, true));
    const auto& integrals = table.integrals();
    ASSERT_EQ(integrals.size(), static_cast<std::size_t>(4 * table.size()));
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (int i = 1; i < table.size(); ++i) {
      const double hu = table.first_hu() + i;
      sum += 0.5 * (premultiplied(table, hu - 1) + premultiplied(table, hu));
      for (int c = 0; c < 4; ++c) {
        const std::int32_t found = integrals[static_cast<std::size_t>(4 * i + c)];
        EXPECT_LE(std::abs(found * table.quantum() - sum[c]), 0.51 * table.quantum()) << i;
      }
    }
    EXPECT_LE(integrals[integrals.size() - 1], 1 << 30) << "sums of two stay within int32";
  }
}

TEST(TransferTableTest, RoundsLikeTheStandardLibrary) {
  for (const double x : {0.0, std::nextafter(0.5, 0), 0.5, 1.5, 2.5, std::nextafter(2.5, 0)}) {
    EXPECT_EQ(rounded(x), std::lround(x)) << x;
  }
  std::mt19937 random(3);
  std::uniform_real_distribution<double> some(0, 1 << 30);
  for (int i = 0; i < 10000; ++i) {
    const double x = some(random);
    EXPECT_EQ(rounded(x), std::lround(x)) << x;
    EXPECT_EQ(rounded(std::floor(x) + 0.5), std::lround(std::floor(x) + 0.5)) << x;
  }
}

TEST(TransferTableTest, RangeQueriesEqualBruteForce) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> anywhere(-300, 500);
  int visible = 0;
  constexpr int kFunctions = 60;
  constexpr int kRanges = 100;
  for (int f = 0; f < kFunctions; ++f) {
    const TransferFunction function = random_function(random, f % 2 == 0);
    const TransferTable table(function);
    for (int r = 0; r < kRanges; ++r) {
      const int a = anywhere(random);
      const int b = r % 3 == 0 ? a : anywhere(random);
      const auto [low, high] = std::minmax(a, b);
      bool expected = false;
      float importance = 0;
      for (int hu = low - 1; hu <= high + 1; ++hu) {
        const double held = std::clamp<double>(hu, table.first_hu(), table.last_hu());
        expected = expected || is_visible(function, held);
        importance =
            std::max(importance, static_cast<float>(entry_importance(function, table, held)));
      }
      EXPECT_EQ(table.visible(low, high), expected) << low << ' ' << high;
      EXPECT_EQ(table.max_importance(low, high), importance) << low << ' ' << high;
      visible += expected ? 1 : 0;
    }
  }
  EXPECT_GT(visible, kFunctions * kRanges / 10);
  EXPECT_LT(visible, kFunctions * kRanges * 9 / 10);
}

TEST(TransferTableTest, NoValueExceedsTheBoundsOfItsRange) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(-250, 450);
  std::uniform_real_distribution<double> gradient(0, 150);
  int invisible = 0;
  for (int f = 0; f < 40; ++f) {
    TransferComponent a = random_component(random, false);
    if (f % 2 == 0) a.gradient = GradientWindow{20, 40, 60, 100};
    const TransferTable table(
        *TransferFunction::blend("two", {a, random_component(random, false)}));
    for (int r = 0; r < 50; ++r) {
      const double low = anywhere(random);
      const double high = low + r % 10;
      const bool visible = table.visible(low, high);
      const double most = table.max_importance(low, high);
      invisible += visible ? 0 : 1;
      for (double hu = low; hu <= high; hu += 1.0 / 16) {
        const TransferSample s = table.at(hu, gradient(random));
        EXPECT_TRUE(visible || s.tau_per_mm == 0) << hu;
        EXPECT_LE(s.importance, most) << hu;
        const bool all_clear = visible || table.rows() > 1 || table.mean(low, hu).tau_per_mm == 0;
        EXPECT_TRUE(all_clear) << hu;
      }
    }
  }
  EXPECT_GT(invisible, 50);
}

TEST(TransferTableTest, RowsFollowTheGradientWindows) {
  TransferComponent edge{"edge", {{0, {1, 0, 0}, 0.5, 1}, {100, {1, 0, 0}, 0.5, 1}}, {}};
  edge.gradient = GradientWindow{21, 42, 63, 63};  // Rows are 1 HU/mm apart.
  const TransferComponent haze{
      "haze", {{0, {0, 1, 0}, 0.1, 0.25}, {100, {0, 1, 0}, 0.1, 0.25}}, {}};
  const TransferFunction function = *TransferFunction::blend("both", {edge, haze});
  const TransferTable table(function);
  EXPECT_EQ(table.rows(), TransferTable::kGradientRows);
  EXPECT_NEAR(table.gradient_per_row(), 1, 1e-12);
  for (const double gradient : {0.0, 10.0, 21.0, 30.0, 42.0, 62.0, 500.0}) {
    const TransferSample s = table.at(50, gradient);
    const TransferSample expected = function.at(50, std::min(gradient, 63.0));
    EXPECT_NEAR(s.tau_per_mm, expected.tau_per_mm, kTableRounding) << gradient;
    EXPECT_NEAR((s.rgb - expected.rgb).norm(), 0, kTableRounding) << gradient;
    EXPECT_EQ(s.importance, static_cast<float>(expected.importance)) << gradient;
  }
  EXPECT_EQ(table.at(50, 21.49).importance, 0.25);
  EXPECT_EQ(table.at(50, 21.51).importance, 1) << "the nearest row decides";
}

TEST(TransferTableTest, AWindowThatContainsAllGradientsChangesNothing) {
  const std::vector<TransferNode> nodes{{0, {1, 0, 0}, 0.1, 1}, {50, {0, 1, 0}, 0.6, 0.5}};
  const TransferTable plain(*TransferFunction::create("plain", nodes));
  const TransferTable windowed(
      *TransferFunction::blend("all", {{"all", nodes, GradientWindow{0, 0, kEndless, kEndless}}}));
  EXPECT_GT(windowed.rows(), 1);
  for (const double gradient : {0.0, 1e-9, 1.0, 1e6}) {
    EXPECT_EQ(windowed.at(20.3, gradient).tau_per_mm, plain.at(20.3).tau_per_mm);
    EXPECT_EQ(windowed.at(20.3, gradient).rgb, plain.at(20.3).rgb);
  }
}

TEST(TransferTableTest, KnowsTheHighestInvisibleValue) {
  const auto up_to = [](double first_opacity, double last_opacity) {
    return TransferTable(*TransferFunction::create("ramp", {{-10, {1, 1, 1}, first_opacity, 0},
                                                            {20, {1, 1, 1}, first_opacity, 0},
                                                            {30, {1, 1, 1}, last_opacity, 0}}))
        .invisible_up_to_hu();
  };
  EXPECT_EQ(up_to(0, 0.5), 20);
  EXPECT_EQ(up_to(0.1, 0.5), -kEndless);
  EXPECT_EQ(up_to(0, 0), kEndless);
}

TEST(TransferTableTest, RoundsNodesBetweenWholeHuOutwards) {
  const auto function =
      *TransferFunction::create("between", {{-0.5, {1, 1, 1}, 0, 0}, {10.25, {1, 1, 1}, 0.5, 0}});
  const TransferTable table(function);
  EXPECT_EQ(table.first_hu(), -1);
  EXPECT_EQ(table.last_hu(), 11);
  EXPECT_EQ(table.size(), 13);
}

TEST(TransferTableTest, LimitsValuesToInt16) {
  const auto wide =
      *TransferFunction::create("wide", {{-40000, {1, 1, 1}, 0, 0}, {40000, {1, 1, 1}, 0.5, 0}});
  const TransferTable table(wide);
  EXPECT_EQ(table.first_hu(), -32768);
  EXPECT_EQ(table.last_hu(), 32767);
  EXPECT_NEAR(table.at(1234).tau_per_mm, wide.at(1234).tau_per_mm, kTableRounding);
  for (const double hu : {-50000.0, 50000.0}) {
    const auto beyond =
        *TransferFunction::create("beyond", {{hu, {1, 1, 1}, 0.5, 0}, {hu + 10, {1, 1, 1}, 0, 0}});
    EXPECT_NEAR(TransferTable(beyond).at(0).tau_per_mm, beyond.at(0).tau_per_mm, kTableRounding);
  }
}

}  // namespace
}  // namespace nav::render
