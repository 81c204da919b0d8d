// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "render/spec/ray_spec_cutaway.hpp"

namespace nav::render::spec {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDoubleRounding = 1e-12;
const CutawaySpan<double> kSpan{100, 80};  // T2 and T1.
constexpr double kOverlay = 20;            // The region is clear below 60 mm.

double up(double x) { return std::nextafter(x, kInfinity); }
double down(double x) { return std::nextafter(x, -kInfinity); }

TEST(OcclusionTest, IsCorrectWithinAnUlpOfEveryBoundary) {
  const auto omega = [](double t) { return occlusion(kSpan, kOverlay, t); };
  EXPECT_EQ(omega(up(100)), 0);
  EXPECT_EQ(omega(100), 0);
  EXPECT_GT(omega(down(100)), 0);
  EXPECT_NEAR(omega(down(100)), 0, kDoubleRounding);
  EXPECT_EQ(omega(90), 0.25);
  EXPECT_NEAR(omega(up(80)), 0.5, kDoubleRounding);
  EXPECT_EQ(omega(80), 0.5);
  EXPECT_NEAR(omega(down(80)), 0.5, kDoubleRounding);
  EXPECT_GT(omega(down(80)), 0.5);
  EXPECT_EQ(omega(70), 0.75);
  EXPECT_LT(omega(up(60)), 1);
  EXPECT_EQ(omega(60), 1);
  EXPECT_EQ(omega(down(60)), 1);
  EXPECT_EQ(omega(-1e9), 1);
}

TEST(OcclusionTest, NeverGrowsAlongTheRay) {
  for (const double overlay : {0.0, 1e-9, 15.0, kInfinity}) {
    for (const double t1 : {80.0, 99.999999, 100.0}) {
      double last = 1;
      for (double t = -50; t < 150; t += 0.0625) {
        const double omega = occlusion(CutawaySpan<double>{100, t1}, overlay, t);
        EXPECT_TRUE(omega >= 0 && omega <= last) << t;
        last = omega;
      }
    }
  }
}

TEST(OcclusionTest, EqualAnglesAndNoOverlayGiveSteps) {
  const CutawaySpan<double> equal{100, 100};
  EXPECT_EQ(occlusion(equal, 20.0, 100.0), 0);
  EXPECT_NEAR(occlusion(equal, 20.0, down(100)), 0.5, kDoubleRounding);
  EXPECT_EQ(occlusion(equal, 20.0, 80.0), 1);
  EXPECT_EQ(occlusion(kSpan, 0.0, 80.0), 0.5) << "still the transition's end";
  EXPECT_EQ(occlusion(kSpan, 0.0, down(80)), 1);
  // The simple cutaway is all or nothing.
  EXPECT_EQ(occlusion(equal, 0.0, 100.0), 0);
  EXPECT_EQ(occlusion(equal, 0.0, down(100)), 1);
}

TEST(OcclusionTest, AnInfiniteOverlayHasNoClearRegion) {
  EXPECT_EQ(occlusion(kSpan, kInfinity, 79.0), 0.5);
  EXPECT_EQ(occlusion(kSpan, kInfinity, -1e12), 0.5);
}

TEST(OcclusionTest, WithoutASurfaceNothingIsOccluded) {
  const CutawaySpan<double> none{-kInfinity, -kInfinity};
  EXPECT_EQ(occlusion(none, 20.0, 0.0), 0);
  EXPECT_EQ(occlusion(none, kInfinity, 5.0), 0);
  for (const double importance : {0.0, 0.3, 0.5, 0.7, 1.0}) {
    EXPECT_EQ(visible_from(none, 20.0, importance), -kInfinity);
    EXPECT_EQ(visible_from(none, kInfinity, importance), -kInfinity);
  }
}

/// The ramp as printed in the paper: the upper end is tested first.
double printed_ramp(double a, double b, double x) {
  return x >= b ? 1 : x <= a ? 0 : (x - a) / (b - a);
}
double printed_visibility(double importance, double omega) {
  return 1 - printed_ramp(std::max(2 * importance - 1, 0.0), importance, omega);
}

TEST(VisibilityTest, ThePrintedRampContradictsTheTextOfThePaper) {
  // "In the base region nothing is cut": the printed ramp(0, 0, 0) removes I = 0 there.
  EXPECT_EQ(printed_visibility(0, 0), 0);
  EXPECT_EQ(visibility(0.0, 0.0), 1);
  // "Materials of highest importance (I = 1) are visible everywhere": ramp(1, 1, 1) removes them.
  EXPECT_EQ(printed_visibility(1, 1), 0);
  EXPECT_EQ(visibility(1.0, 1.0), 1);
  // The two are equal everywhere else.
  for (double importance = 1.0 / 64; importance < 1; importance += 1.0 / 64) {
    for (double omega = 0; omega <= 1; omega += 1.0 / 128) {
      EXPECT_NEAR(visibility(importance, omega), printed_visibility(importance, omega),
                  kDoubleRounding)
          << importance << ' ' << omega;
    }
  }
}

TEST(VisibilityTest, HasTheTabulatedValues) {
  constexpr double kTiny = 1e-9;
  struct Row {
    double importance;
    double at[5];  ///< Omega = 0, tiny, 1/2, 1 - tiny, 1.
  };
  const double omegas[5] = {0, kTiny, 0.5, 1 - kTiny, 1};
  const double nearly = 1 - 1.0 / 16777216;
  const Row rows[] = {{0, {1, 0, 0, 0, 0}},
                      {1e-6, {1, 1 - 1e-3, 0, 0, 0}},
                      {0.5, {1, 1 - 2e-9, 0, 0, 0}},
                      {down(0.5), {1, 1 - 2e-9, 0, 0, 0}},
                      {up(0.5), {1, 1 - 2e-9, 4.5e-16, 0, 0}},
                      {0.75, {1, 1, 1, 0, 0}},
                      {nearly, {1, 1, 1, 0, 0}},
                      {1, {1, 1, 1, 1, 1}}};
  for (const Row& row : rows) {
    for (int i = 0; i < 5; ++i) {
      const double found = visibility(row.importance, omegas[i]);
      EXPECT_TRUE(found >= 0 && found <= 1);
      EXPECT_NEAR(found, row.at[i], 1e-8) << row.importance << ' ' << omegas[i];
    }
  }
  // Both ends are exact.
  EXPECT_EQ(visibility(0.0, kTiny), 0);
  EXPECT_EQ(visibility(nearly, 1.0), 0) << "why tables snap it to 1";
  EXPECT_EQ(visibility(1.0, 1 - kTiny), 1);
  EXPECT_EQ(visibility(0.75, 0.625), 0.5);
  EXPECT_EQ(visibility(0.25, 0.125), 0.5);
}

TEST(VisibilityTest, GrowsWithImportanceAndFallsWithOcclusion) {
  for (double importance = 0; importance <= 1; importance += 1.0 / 256) {
    for (double omega = 0; omega <= 1; omega += 1.0 / 256) {
      const double here = visibility(importance, omega);
      EXPECT_GE(here, visibility(importance, omega + 1.0 / 256));
      EXPECT_LE(here, visibility(importance + 1.0 / 256, omega));
    }
  }
}

TEST(FadedTest, DoesNotDependOnTheStep) {
  // One unit of length with opacity 0.6, half faded, gives 0.3 for any number of steps.
  const double tau = -std::log1p(-0.6);
  for (const int steps : {1, 4, 64, 4096}) {
    double through = 1;
    for (int i = 0; i < steps; ++i) through *= std::exp(-faded(tau, 0.5) / steps);
    EXPECT_NEAR(1 - through, 0.3, kDoubleRounding) << steps;
  }
}

TEST(FadedTest, TheOppositeOrderDependsOnTheStep) {
  // This order corrects the opacity to the step first and fades it then. The specification must not
  // do so.
  const auto other = [](double h) {
    const double alpha = -std::expm1(h * std::log1p(-0.6));
    return -std::expm1(std::log1p(-0.5 * alpha) / h);
  };
  EXPECT_NEAR(other(1), 0.300, 5e-4);
  EXPECT_NEAR(other(0.25), 0.351, 5e-4);
  EXPECT_NEAR(other(1e-6), 0.368, 5e-4);
}

TEST(FadedTest, KeepsTinyOpacitiesAndExactEnds) {
  for (const double tau : {1e-30, 1e-12, 1e-6}) {
    EXPECT_NEAR(faded(tau, 0.25) / (0.25 * tau), 1, 1e-6);
    EXPECT_NEAR(faded(static_cast<float>(tau), 0.25F) / (0.25F * static_cast<float>(tau)), 1, 1e-5);
  }
  EXPECT_EQ(faded(3.0, 1.0), 3.0);
  EXPECT_EQ(faded(3.0, 0.0), 0);
  EXPECT_EQ(faded(0.0, 0.5), 0);
  EXPECT_NEAR(faded(700.0, 0.5), std::log(2.0), kDoubleRounding) << "an opaque sample half faded";
}

/// Expects that everything up to visible_from() is invisible to the last bit in the precision of S,
/// and that it is visible slightly beyond.
template <class S>
void expect_consistent(S slack_mm) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 20000; ++trial) {
    const auto t1 = static_cast<S>(2000 * unit(random) - 500);
    const S gap = trial % 3 == 0 ? S(0) : static_cast<S>(100 * unit(random));
    const CutawaySpan<S> span{t1 + gap, t1};
    const S overlay = trial % 5 == 0 ? S(0) : static_cast<S>(50 * unit(random));
    const S importance = trial % 7 == 0 ? S(0.5) : static_cast<S>(unit(random));
    const S from = visible_from(span, overlay, importance);
    EXPECT_EQ(visibility(importance, occlusion(span, overlay, from)), S(0)) << trial;
    for (int i = 0; i < 8; ++i) {
      const auto before = from - static_cast<S>(30 * unit(random) * unit(random));
      EXPECT_EQ(visibility(importance, occlusion(span, overlay, before)), S(0)) << trial;
    }
    EXPECT_GT(visibility(importance, occlusion(span, overlay, from + slack_mm)), S(0)) << trial;
  }
}

TEST(VisibleFromTest, SkipsOnlyWhatIsInvisibleToTheLastBit) {
  expect_consistent<double>(1e-10);
  expect_consistent<float>(2e-2F);
}

TEST(VisibleFromTest, TheMostImportantMaterialIsNeverSkipped) {
  EXPECT_EQ(visible_from(kSpan, kOverlay, 1.0), -kInfinity);
  EXPECT_EQ(visible_from(kSpan, kInfinity, 0.75), -kInfinity) << "no clear region to vanish in";
  EXPECT_NEAR(visible_from(kSpan, kOverlay, 0.75), 70, kDoubleRounding * 100);
  EXPECT_NEAR(visible_from(kSpan, kOverlay, 0.25), 90, kDoubleRounding * 100);
  EXPECT_NEAR(visible_from(kSpan, kOverlay, 0.0), 100, kDoubleRounding * 100);
}

}  // namespace
}  // namespace nav::render::spec
