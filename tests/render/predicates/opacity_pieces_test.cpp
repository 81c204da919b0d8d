// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/opacity_pieces.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>

namespace nav::render {
namespace {

double exact(const IntensityOpacity& extinction, double x, double step_mm) {
  return -std::expm1(-extinction.tau(x) * step_mm);
}

/// Evaluates the pieces like the vector code.
double by_pieces(const OpacityPieces& pieces, float x) {
  EXPECT_LE(x, OpacityPieces::kWhitest);
  const float z = OpacityPieces::kMost - x;
  const auto bits = std::bit_cast<std::uint32_t>(z);
  const int piece = static_cast<int>(bits >> 23) - 119;
  EXPECT_GE(piece, 0) << x;
  EXPECT_LT(piece, OpacityPieces::kPieces) << x;
  const float t = std::bit_cast<float>((bits & 0x007fffffU) | 0x3f800000U) - 1;
  float sum = 0;
  for (int i = OpacityPieces::kFactors - 1; i >= 0; --i) sum = sum * t + pieces.of[i][piece];
  return sum;
}

/// Largest error over the intensities [\p from, \p up_to]. If \p relative, relative to the opacity.
double greatest_error(double step_mm, float from, float up_to, bool relative) {
  const IntensityOpacity extinction(2);
  const OpacityPieces pieces = opacity_pieces(extinction, step_mm).value();
  double most = 0;
  constexpr int kCount = 200000;
  for (int i = 0; i <= kCount; ++i) {
    const float x = from + (up_to - from) * static_cast<float>(i) / kCount;
    const double truth = exact(extinction, x, step_mm);
    const double error = std::abs(by_pieces(pieces, x) - truth);
    most = std::max(most, relative ? error / truth : error);
  }
  return most;
}

TEST(OpacityPieces, ApproximatesTheOpacityForEveryStep) {
  // 254/255 is the largest 8-bit intensity except for white. There the definition, which is linear
  // between entries, has corners.
  for (const double step_mm : {0.005, 0.05, 0.3, 1.0, 3.0}) {
    EXPECT_LT(greatest_error(step_mm, 0, 0.95F, false), 2e-5) << step_mm;
    EXPECT_LT(greatest_error(step_mm, 0, 254.0F / 255, false), 5e-4) << step_mm;
    EXPECT_LT(greatest_error(step_mm, 1.0F / 255, 0.95F, true), 2e-4) << step_mm;
  }
}

TEST(OpacityPieces, WhiteIsExact) {
  const IntensityOpacity extinction(2);
  for (const double step_mm : {0.005, 0.3, 3.0}) {
    const OpacityPieces pieces = opacity_pieces(extinction, step_mm).value();
    EXPECT_FLOAT_EQ(pieces.white, static_cast<float>(exact(extinction, 1, step_mm))) << step_mm;
  }
}

TEST(OpacityPieces, BlackAndNearlyBlackAreAccurate) {
  const IntensityOpacity extinction(2);
  const OpacityPieces pieces = opacity_pieces(extinction, 0.05).value();
  EXPECT_NEAR(by_pieces(pieces, 0.0F), 0, 1e-8);
  for (const float x : {1e-6F, 1e-4F, 1.0F / 255}) {
    const double truth = exact(extinction, x, 0.05);
    EXPECT_NEAR(by_pieces(pieces, x), truth, 2e-4 * truth + 3e-9) << x;
  }
}

TEST(OpacityPieces, IsNotUsedIfItWouldBeInaccurate) {
  // With an opacity length of 2 mm and ever longer cells, the pieces are either accurate or not
  // used.
  constexpr double kMostError = 2e-3;
  bool refused = false;
  for (double step_mm = 1; step_mm < 1e5; step_mm *= 1.3) {
    if (opacity_pieces(IntensityOpacity(2), step_mm)) {
      EXPECT_FALSE(refused) << step_mm;
      EXPECT_LT(greatest_error(step_mm, 0, 254.0F / 255, false), kMostError) << step_mm;
    } else {
      refused = true;
      EXPECT_GT(step_mm, 10) << "needlessly slow";
    }
  }
  EXPECT_TRUE(refused);
}

TEST(OpacityPieces, GrowsWithTheIntensity) {
  constexpr double kStepMm = 0.1;
  constexpr int kCount = 4096;
  const IntensityOpacity extinction(2);
  const OpacityPieces pieces = opacity_pieces(extinction, kStepMm).value();
  double before = 0;
  for (int i = 1; i <= kCount; ++i) {
    const float x = OpacityPieces::kWhitest * static_cast<float>(i) / kCount;
    const double now = by_pieces(pieces, x);
    EXPECT_GE(now, before) << i;
    before = now;
  }
  EXPECT_GE(exact(extinction, OpacityPieces::kWhitest + 1e-4, kStepMm), before);
}

}  // namespace
}  // namespace nav::render
