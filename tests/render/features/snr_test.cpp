// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/snr.hpp"

#include "render/features/definition.hpp"
#include "tests/render/features/derived_support.hpp"

namespace nav::render::features {
namespace {

constexpr double kFloatRounding = 3e-7;

void expect_definition(const ScalarVolume& volume, const SnrOptions& options, double tolerance) {
  const auto found = signal_to_noise(volume, options);
  ASSERT_TRUE(test::has_value(found));
  const auto& size = volume.grid().size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const double truth = definition::signal_to_noise(volume, options, i, j, k);
        const double here = found->at(i, j, k);
        if (std::isnan(truth)) {
          EXPECT_TRUE(std::isnan(here)) << i << ' ' << j << ' ' << k;
        } else if (std::isinf(truth)) {
          EXPECT_EQ(here, truth);
        } else {
          EXPECT_NEAR(here, truth, tolerance * (1 + std::abs(truth))) << i << ' ' << j << ' ' << k;
        }
      }
    }
  }
}

TEST(SnrTest, EqualsItsDefinitionForAllSizesWindowsAndWeights) {
  unsigned seed = 1;
  for (const std::array<int, 3> size :
       {std::array{19, 11, 9}, {8, 8, 8}, {1, 17, 5}, {23, 1, 1}, {3, 2, 1}, {1, 1, 1}}) {
    for (const auto weights : {WindowWeights::kUniform, WindowWeights::kGaussian}) {
      for (const int window : {3, 7}) {
        expect_definition(test::speckled(test::centred_grid(size, {0.2, 0.2, 1}), seed++),
                          {window, weights}, kFloatRounding);
      }
    }
  }
}

TEST(SnrTest, LeavesUnknownVoxelsOutOfTheWindow) {
  const auto grid = test::centred_grid({16, 12, 10}, {1, 1, 1});
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  std::bernoulli_distribution unknown(0.4);
  const auto volume = test::make_scalar(grid, [&](int i, int j, int) {
    return unknown(random) || (i > 9 && j > 8) ? std::nan("") : 50 + 9 * noise(random);
  });
  expect_definition(volume, {}, kFloatRounding);
}

TEST(SnrTest, SignalIsRelativeToBlack) {
  const auto grid = test::centred_grid({14, 10, 9}, {1, 1, 1});
  const auto at = [&](double shift) {
    std::mt19937 random(11);
    std::normal_distribution<double> noise;
    return test::make_scalar(
        grid, [&](int, int, int) { return shift + std::round(60 + 9 * noise(random)); });
  };
  const auto plain = signal_to_noise(at(0));
  const auto shifted = signal_to_noise(at(-1000), {.black = -1000});
  ASSERT_TRUE(test::has_value(plain) && test::has_value(shifted));
  constexpr double kRounding = 1e-5;
  for (std::size_t n = 0; n < plain->values->size(); ++n) {
    EXPECT_NEAR((*plain->values)[n], (*shifted->values)[n], kRounding);
  }
  expect_definition(at(600), {.black = 600}, kFloatRounding);
  EXPECT_TRUE(test::rejects(signal_to_noise(at(0), {.black = std::nan("")}), ErrorCode::kUsage,
                            {"black", "nan"}));
}

TEST(SnrTest, ALargeOffsetLosesNoPrecision) {
  const auto grid = test::centred_grid({12, 12, 12}, {1, 1, 1});
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  // A float near 2^20 resolves 1/16. The sum of squares in double would lose 8 of 15 digits.
  const auto volume = test::make_scalar(
      grid, [&](int, int, int) { return 1048576 + std::round(noise(random) * 16) / 16; });
  expect_definition(volume, {}, kFloatRounding);
}

TEST(SnrTest, ARampHasTheMeanOverTheSpreadOfSevenSteps) {
  const auto grid = test::centred_grid({15, 15, 15}, {1, 1, 1});
  const auto volume = test::make_scalar(grid, [](int i, int, int) { return 10.0 + 2 * i; });
  const auto snr = signal_to_noise(volume);
  ASSERT_TRUE(test::has_value(snr));
  // -3 … 3 in steps of 2 units has the variance 4 * 4.
  EXPECT_FLOAT_EQ(snr->at(7, 7, 7), 24.0F / 4.0F);
}

TEST(SnrTest, AConstantIsLimitedByRoundingOrInfinite) {
  const auto grid = test::centred_grid({9, 9, 9}, {1, 1, 1});
  const auto whole = ScalarVolume::of(test::make_volume(grid, [](int, int, int) { return 255; }));
  EXPECT_NEAR(signal_to_noise(whole)->at(4, 4, 4), 255 * std::sqrt(12.0), 1e-3);
  const auto real = test::make_scalar(grid, [](int, int, int) { return 255; });
  EXPECT_TRUE(std::isinf(signal_to_noise(real)->at(4, 4, 4)));
  const auto black = test::make_scalar(grid, [](int, int, int) { return 0; });
  EXPECT_TRUE(std::isnan(signal_to_noise(black)->at(4, 4, 4)));
  const auto nothing = test::make_scalar(grid, [](int, int, int) { return std::nan(""); });
  EXPECT_TRUE(std::isnan(signal_to_noise(nothing)->at(4, 4, 4)));
}

TEST(SnrTest, WindowIsLinearBetweenItsEnds) {
  EXPECT_EQ(windowed(1, 2, 4), 0);
  EXPECT_EQ(windowed(3.5, 2, 4), 0.75);
  EXPECT_EQ(windowed(std::numeric_limits<double>::infinity(), 2, 4), 1);
  EXPECT_TRUE(std::isnan(windowed(std::nan(""), 2, 4)));
}

TEST(SnrTest, RejectsEvenWindowsAndTooLittleMemory) {
  const auto volume = test::speckled(test::centred_grid({4, 4, 4}, {1, 1, 1}), 1);
  EXPECT_EQ(signal_to_noise(volume, {6, WindowWeights::kUniform}).error().code, ErrorCode::kUsage);
  RunOptions run;
  run.memory_limit = 100;
  EXPECT_EQ(signal_to_noise(volume, {}, run).error().code, ErrorCode::kUnsupportedData);
}

TEST(SnrTest, DoesNotDependOnTheNumberOfThreads) {
  const auto volume = test::speckled(test::centred_grid({33, 21, 18}, {1, 1, 1}), 5);
  RunOptions one;
  one.threads = 1;
  RunOptions three;
  three.threads = 3;
  EXPECT_TRUE(test::same_bytes(*signal_to_noise(volume, {}, one)->values,
                               *signal_to_noise(volume, {}, three)->values));
}

}  // namespace
}  // namespace nav::render::features
