// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer_table.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace nav::render {
namespace {

/// Entries are stored in single precision.
constexpr double kSingle = 1e-6;

TransferFunction random_function(std::mt19937& random, bool whole) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<TransferNode> nodes;
  double hu = -200 * unit(random);
  const int count = 2 + static_cast<int>(6 * unit(random));
  for (int i = 0; i < count; ++i) {
    const double opacity = unit(random) < 0.6 ? 0 : 0.9 * unit(random);
    nodes.push_back({whole ? std::round(hu) : hu,
                     {unit(random), unit(random), unit(random)},
                     opacity,
                     unit(random)});
    hu += 2 + 60 * unit(random);
  }
  return *TransferFunction::create("random", nodes);
}

/// Extinction as the table gives it: linear between the entries, held outside.
double interpolated(const TransferTable& table, double hu) {
  const double x = std::clamp((hu - table.first_hu()) * table.per_hu(), 0.0, table.size() - 1.0);
  const auto i = std::min(static_cast<std::size_t>(x), static_cast<std::size_t>(table.size()) - 2);
  const double w = x - static_cast<double>(i);
  return (1 - w) * table.rgbat()[4 * i + 3] + w * table.rgbat()[4 * i + 7];
}

TEST(TransferTableTest, IsExactForNodesAtWholeHu) {
  std::mt19937 random(1);
  for (int f = 0; f < 20; ++f) {
    const TransferFunction function = random_function(random, true);
    for (const TransferTable& table :
         {TransferTable::at_whole_hu(function), TransferTable::for_texture(function)}) {
      EXPECT_EQ(table.per_hu(), 1);
      EXPECT_EQ(table.first_hu(), function.values().front());
      EXPECT_EQ(table.last_hu(), function.values().back());
      for (double hu = table.first_hu() - 3; hu < table.last_hu() + 3; hu += 0.25) {
        EXPECT_NEAR(interpolated(table, hu), function.at(hu).tau_per_mm, kSingle) << hu;
      }
      for (int i = 0; i < table.size(); ++i) {
        const Eigen::Vector3d rgb = function.at(table.first_hu() + i).rgb;
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(table.rgbat()[static_cast<std::size_t>(4 * i + c)], rgb(c), kSingle);
        }
      }
    }
  }
}

TEST(TransferTableTest, RangeQueryEqualsBruteForce) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> anywhere(-300, 500);
  int visible = 0;
  constexpr int kFunctions = 60;
  constexpr int kRanges = 100;
  for (int f = 0; f < kFunctions; ++f) {
    const TransferFunction function = random_function(random, true);
    const TransferTable whole = TransferTable::at_whole_hu(function);
    const TransferTable texture = TransferTable::for_texture(function);
    for (int r = 0; r < kRanges; ++r) {
      const int a = anywhere(random);
      const int b = r % 3 == 0 ? a : anywhere(random);
      const auto [low, high] = std::minmax(a, b);
      bool expected = false;
      for (int hu = low - 1; hu <= high + 1; ++hu) {
        expected = expected || static_cast<float>(function.at(hu).tau_per_mm) > 0;
      }
      EXPECT_EQ(whole.visible(low, high), expected) << low << ' ' << high;
      EXPECT_EQ(texture.visible(low, high), expected) << low << ' ' << high;
      visible += expected ? 1 : 0;
    }
  }
  EXPECT_GT(visible, kFunctions * kRanges / 10);
  EXPECT_LT(visible, kFunctions * kRanges * 9 / 10);
}

TEST(TransferTableTest, NoRangeCalledInvisibleHasAVisibleValue) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> anywhere(-250, 450);
  int invisible = 0;
  for (int f = 0; f < 60; ++f) {
    const TransferFunction function = random_function(random, false);
    for (const TransferTable& table :
         {TransferTable::at_whole_hu(function), TransferTable::for_texture(function)}) {
      for (int r = 0; r < 50; ++r) {
        const int low = anywhere(random);
        const int high = low + r % 10;
        if (table.visible(low, high)) continue;
        ++invisible;
        for (double hu = low; hu <= high; hu += 1.0 / 16) EXPECT_EQ(interpolated(table, hu), 0);
      }
    }
  }
  EXPECT_GT(invisible, 100);
}

TEST(TransferTableTest, KnowsUpToWhereNothingIsVisible) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto up_to = [](double first_opacity, double last_opacity) {
    return TransferTable::at_whole_hu(
               *TransferFunction::create("ramp", {{-10, {1, 1, 1}, first_opacity, 0},
                                                  {20, {1, 1, 1}, first_opacity, 0},
                                                  {30, {1, 1, 1}, last_opacity, 0}}))
        .invisible_up_to_hu();
  };
  EXPECT_EQ(up_to(0, 0.5), 20);
  EXPECT_EQ(up_to(0.1, 0.5), -kInfinity);
  EXPECT_EQ(up_to(0, 0), kInfinity);
}

TEST(TransferTableTest, RoundsNodesBetweenWholeHuOutwards) {
  const auto function =
      *TransferFunction::create("between", {{-0.5, {1, 1, 1}, 0, 0}, {10.25, {1, 1, 1}, 0.5, 0}});
  const TransferTable whole = TransferTable::at_whole_hu(function);
  EXPECT_EQ(whole.first_hu(), -1);
  EXPECT_EQ(whole.last_hu(), 11);
  EXPECT_EQ(whole.size(), 13);
  const TransferTable texture = TransferTable::for_texture(function);
  EXPECT_EQ(texture.first_hu(), -0.5);
  EXPECT_NEAR(texture.last_hu(), 10.25, kSingle);
  EXPECT_EQ(texture.size(), 4096);
}

TEST(TransferTableTest, KeepsToInt16AndToTheWidthOfATexture) {
  const auto wide =
      *TransferFunction::create("wide", {{-40000, {1, 1, 1}, 0, 0}, {40000, {1, 1, 1}, 0.5, 0}});
  const TransferTable whole = TransferTable::at_whole_hu(wide);
  EXPECT_EQ(whole.first_hu(), -32768);
  EXPECT_EQ(whole.last_hu(), 32767);
  EXPECT_NEAR(interpolated(whole, 1234), wide.at(1234).tau_per_mm, kSingle);
  const TransferTable texture = TransferTable::for_texture(wide);
  EXPECT_EQ(texture.size(), 4096);
  EXPECT_NEAR(interpolated(texture, 1234), wide.at(1234).tau_per_mm, kSingle);
  const auto beyond =
      *TransferFunction::create("beyond", {{50000, {1, 1, 1}, 0.5, 0}, {50010, {1, 1, 1}, 0, 0}});
  EXPECT_TRUE(TransferTable::at_whole_hu(beyond).visible(-1024, -1024));
}

TEST(SameTablesTest, MindsWhatTheTableHoldsOnly) {
  const std::vector<TransferNode> nodes{{0, {1, 1, 1}, 0, 0}, {10, {1, 1, 1}, 0.5, 0}};
  const auto changed = [&](auto change) {
    auto other = nodes;
    change(other[1]);
    return *TransferFunction::create("other", other);
  };
  const auto f = *TransferFunction::create("one", nodes);
  EXPECT_TRUE(same_tables(f, changed([](TransferNode&) {})));
  EXPECT_TRUE(same_tables(f, changed([](TransferNode& n) { n.importance = 1; })));
  EXPECT_FALSE(same_tables(f, changed([](TransferNode& n) { n.hu = 11; })));
  EXPECT_FALSE(same_tables(f, changed([](TransferNode& n) { n.rgb.x() = 0; })));
  EXPECT_FALSE(same_tables(f, changed([](TransferNode& n) { n.opacity = 0.4; })));
}

}  // namespace
}  // namespace nav::render
