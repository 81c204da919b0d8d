// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests classification and compositing of predicates against their published definitions.
#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

#include "render/cpu/predicate_early_ends.hpp"

namespace nav::render::spec {
namespace {

struct Sample {
  Rgb<double> rgb;
  double alpha;
  double importance;
};
using Samples = std::vector<Sample>;

/// Eqs. 10 to 12 as De Moura Pinto and Freitas printed them, with premultiplied colours. The test
/// compares with this.
struct Published {
  Rgb<double> rgb = Rgb<double>::Zero();
  double alpha = 0;
  double importance = 0;

  void add(const Sample& s) {
    const double visible = 1 - std::exp(importance - s.importance);
    const double m = s.importance <= importance || 1 - alpha >= visible ? 1 : (1 - visible) / alpha;
    const Rgb<double> mixed = m * rgb + (1 - m * alpha) * s.alpha * s.rgb;
    const double opacity = m * alpha * (1 - s.alpha) + s.alpha;
    alpha = alpha * (1 - s.alpha) + s.alpha;
    rgb = opacity > 0 ? Rgb<double>(alpha * mixed / opacity) : Rgb<double>::Zero();
    importance = std::max(
        importance,
        std::log(s.alpha + (1 - s.alpha) * std::exp(importance - s.importance)) + s.importance);
  }
};

class RayMaker {
 public:
  explicit RayMaker(unsigned seed) : random_(seed) {}
  double unit() { return unit_(random_); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_()) % n; }

  /// A ray with a few importances, opaque samples and faint samples.
  Samples ray(std::size_t most, double most_importance) {
    Samples out(1 + below(most));
    const double faint = std::pow(10, -4 * unit());
    for (Sample& s : out) {
      s = {{unit(), unit(), unit()},
           std::min(1.0, faint * unit() * 2),
           most_importance * std::round(4 * unit()) / 4};
      if (below(20) == 0) s.importance = most_importance * unit();
    }
    return out;
  }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> unit_{0, 1};
};

template <class S>
ImportanceState<S> logs(const Samples& ray) {
  ImportanceState<S> state;
  for (const Sample& s : ray) {
    composite_log<S>(state, s.rgb.cast<S>(), static_cast<S>(s.alpha), static_cast<S>(s.importance));
  }
  return state;
}

template <class S>
ImportanceState<S> weights(const Samples& ray, double greatest) {
  ImportanceState<S> state;
  state.importance = static_cast<S>(std::exp(-greatest));
  for (const Sample& s : ray) {
    composite_weight<S>(state, s.rgb.cast<S>(), static_cast<S>(s.alpha),
                        static_cast<S>(std::exp(s.importance - greatest)));
  }
  return state;
}

template <class S>
double off(const ImportanceState<S>& a, const ImportanceState<double>& b) {
  const Rgb<double> x = (a.alpha * a.rgb).template cast<double>();
  return std::max((x - b.alpha * b.rgb).cwiseAbs().maxCoeff(),
                  std::abs(static_cast<double>(a.alpha) - b.alpha));
}

Rgb<double> premultiplied(const ImportanceState<double>& s) { return s.alpha * s.rgb; }

/// Impacts of importances, in the given order.
std::vector<PredicateWeight> weights_of(const std::vector<double>& kappas) {
  std::vector<PredicateWeight> out;
  for (std::size_t j = 0; j < kappas.size(); ++j) {
    out.push_back({impact_of(kappas[j], kappas.size()), 40.0 * static_cast<double>(j),
                   0.25 * static_cast<double>(1 + j % 4)});
  }
  return out;
}

TEST(PredicateCompositingTest, StableFormsEqualThePublishedRecurrence) {
  RayMaker make(1);
  for (int i = 0; i < 3000; ++i) {
    const Samples ray = make.ray(60, 9);
    Published published;
    for (const Sample& s : ray) published.add(s);
    const auto state = logs<double>(ray);
    EXPECT_LT((premultiplied(state) - published.rgb).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(state.alpha, published.alpha, 1e-13);
    EXPECT_NEAR(state.importance, published.importance, 1e-11);
    EXPECT_LT(off(weights<double>(ray, 9), state), 1e-12);
  }
}

TEST(PredicateCompositingTest, EqualImportancesOfAnySizeGiveTheOverOperator) {
  constexpr double kDouble = 1e-12;
  constexpr double kSingle = 1e-5;
  // I has as many correct digits as its size permits. Engines composite equal importances with
  // "over".
  constexpr double kDigitsOfI = 4e-7;
  RayMaker make(2);
  for (const double kappa : {1e-30, 1e-6, 0.5, 1.0, 9.0, 64.0, 1024.0}) {
    for (int i = 0; i < 100; ++i) {
      Samples ray = make.ray(200, 0);
      ImportanceState<double> over;
      Rgb<double> classic = Rgb<double>::Zero();
      double alpha = 0;
      for (Sample& s : ray) {
        s.importance = kappa;
        composite_over(over, s.rgb, s.alpha);
        classic += (1 - alpha) * s.alpha * s.rgb;
        alpha += (1 - alpha) * s.alpha;
      }
      EXPECT_LT((premultiplied(over) - classic).cwiseAbs().maxCoeff(), kDouble);
      EXPECT_LT(off(logs<double>(ray), over), kDouble) << kappa;
      EXPECT_LT(off(logs<float>(ray), over), kSingle + kDigitsOfI * kappa) << kappa;
      EXPECT_LT(off(weights<double>(ray, kappa), over), kDouble) << kappa;
      EXPECT_LT(off(weights<float>(ray, kappa), over), kSingle) << kappa;
    }
  }
}

TEST(PredicateCompositingTest, SplittingSamplesChangesNothing) {
  RayMaker make(3);
  for (int i = 0; i < 300; ++i) {
    const Samples ray = make.ray(20, 6);
    const auto whole = logs<double>(ray);
    for (const int parts : {2, 7, 64}) {
      Samples split;
      for (Sample s : ray) {
        s.alpha = -std::expm1(std::log1p(-s.alpha) / parts);
        split.insert(split.end(), static_cast<std::size_t>(parts), s);
      }
      EXPECT_LT(off(logs<double>(split), whole), 1e-11);
      EXPECT_LT(off(weights<double>(split, 6), whole), 1e-11);
    }
  }
}

TEST(PredicateCompositingTest, LogAndWeightFormsAgreeForManyPredicatesWithoutOverflow) {
  RayMaker make(4);
  for (const int n : {2, 8, 10, 16, 32}) {
    const double greatest = n * n;  // kappa = (1, 0, ..).
    for (int i = 0; i < 200; ++i) {
      const Samples ray = make.ray(80, greatest);
      const auto exact = logs<double>(ray);
      const auto single = logs<float>(ray);
      ASSERT_TRUE(single.rgb.allFinite() && std::isfinite(single.importance));
      EXPECT_LT(off(single, exact), 2e-4) << n;  // exp(1e-7 · 1024) is 1 + 1e-4.
      if (weights_suffice(0, greatest)) {
        EXPECT_LT(off(weights<float>(ray, greatest), exact), 1e-5) << n;
      }
    }
  }
  EXPECT_TRUE(weights_suffice(0, 8.0 * 8));
  EXPECT_FALSE(weights_suffice(0, 9.0 * 9));
}

TEST(PredicateCompositingTest, OpacitiesOfZeroAndOneGiveFiniteColours) {
  for (const float alpha : {0.0F, 1e-38F, 1e-7F, 1 - 0x1p-24F, 1.0F}) {
    ImportanceState<float> log;
    ImportanceState<float> weight;
    weight.importance = std::exp(-4.0F);
    for (int i = 0; i < 3; ++i) {
      composite_log<float>(log, {1, 0.5F, 0}, alpha, 4);
      composite_weight<float>(weight, {1, 0.5F, 0}, alpha, 1);
    }
    EXPECT_TRUE(log.rgb.allFinite() && weight.rgb.allFinite()) << alpha;
    EXPECT_NEAR(log.alpha, -std::expm1(3 * std::log1p(-std::min(alpha, 0.9999999F))), 1e-6);
    EXPECT_NEAR(log.rgb.x(), alpha > 0 ? 1 : 0, 1e-6) << "the colour of what there is";
    EXPECT_EQ(log.alpha, weight.alpha);
  }
}

TEST(PredicateCompositingTest, SinglePrecisionDoesNotDriftAlongLongRays) {
  RayMaker make(5);
  for (const std::size_t count : {2000UL, 100'000UL}) {
    Samples ray(count);
    for (std::size_t i = 0; i < count; ++i) {
      ray[i] = {{make.unit(), make.unit(), make.unit()},
                5.0 / static_cast<double>(count) * make.unit(),
                std::round(3 * make.unit()) * 2};
    }
    const auto exact = logs<double>(ray);
    const double limit = 2e-9 * static_cast<double>(count) + 4e-6;
    EXPECT_LT(off(weights<float>(ray, 6), exact), limit) << count;
    EXPECT_LT(off(logs<float>(ray), exact), limit) << count;
  }
}

/// The worst ray to stop: black and opaque in front, white and a little more important behind.
Samples adversarial(RayMaker& make, double more) {
  Samples ray(5, {Rgb<double>::Zero(), 0.9, 2});
  const std::size_t behind = 1 + make.below(400);
  const double alpha = make.below(2) == 0 ? 1e-5 : make.unit();
  ray.insert(ray.end(), behind, {Rgb<double>::Ones(), alpha, 2 + more});
  return ray;
}

/// The greatest importance of the samples from i to the end.
std::vector<double> suffix_maxima(const Samples& ray) {
  std::vector<double> out(ray.size() + 1, 0);
  for (std::size_t i = ray.size(); i-- > 0;) out[i] = std::max(out[i + 1], ray[i].importance);
  return out;
}

TEST(EarlyTerminationTest, BoundHoldsOnAHundredThousandRays) {
  RayMaker make(6);
  int violations = 0;
  double tightest = 0;
  double naive_worst = 0;
  for (int i = 0; i < 100'000; ++i) {
    const double kinds[] = {0, 1e-6, 1e-3, 0.1, 1, 5};
    const Samples ray = i % 4 == 0 ? adversarial(make, kinds[make.below(6)]) : make.ray(40, 6);
    const auto maxima = suffix_maxima(ray);
    const std::size_t stop = make.below(ray.size());
    ImportanceState<double> state;
    ImportanceState<double> at_stop;
    double through = 1;
    for (std::size_t s = 0; s < ray.size(); ++s) {
      if (s == stop) at_stop = state;
      if (s >= stop) through *= 1 - ray[s].alpha;
      composite_log(state, ray[s].rgb, ray[s].alpha, ray[s].importance);
    }
    const double bound = remaining_change(at_stop.alpha, at_stop.importance, maxima[stop]);
    const double tighter =
        remaining_change(at_stop.alpha, at_stop.importance, maxima[stop], through);
    const double colour = (premultiplied(state) - premultiplied(at_stop)).cwiseAbs().maxCoeff();
    const double plain = at_stop.alpha > 0 ? (state.rgb - at_stop.rgb).cwiseAbs().maxCoeff() : 0;
    const Rgb<double> on_white = premultiplied(state) - premultiplied(at_stop) +
                                 Rgb<double>::Constant(at_stop.alpha - state.alpha);
    const double pixel = on_white.cwiseAbs().maxCoeff();
    constexpr double kRounding = 1e-12;
    const double found = std::max({colour, plain, pixel, state.alpha - at_stop.alpha});
    if (found > bound + kRounding || colour > tighter + kRounding) ++violations;
    if (bound > 1e-6) tightest = std::max(tightest, found / bound);
    if (1 - at_stop.alpha <= 1.0 / 255) naive_worst = std::max(naive_worst, colour);
  }
  EXPECT_EQ(violations, 0);
  EXPECT_GT(tightest, 0.999) << "a bound that nothing comes near is not the theorem's";
  EXPECT_GT(naive_worst, 0.5) << "stopping by opacity alone is wrong, and this must show it";
}

/// The two rules of EarlyEnds on one ray, with the exact maxima of the rest of the ray.
ImportanceState<double> terminated(const Samples& ray, double error) {
  const auto budget = early_ends<double>(error, false);
  const auto maxima = suffix_maxima(ray);
  ImportanceState<double> state;
  LeftOut<double> left_out;
  for (std::size_t i = 0; i < ray.size(); ++i) {
    const double kept = std::exp(-std::max(0.0, maxima[i] - state.importance));
    if (!left_out.any && state.alpha * kept >= budget.end_at) break;
    if (state.alpha >= budget.leave_out_from &&
        left_out.pay(state, ray[i].importance, budget.leave_out_for)) {
      continue;
    }
    const double before = state.importance;
    composite_log(state, ray[i].rgb, ray[i].alpha, ray[i].importance);
    if (state.importance > before) left_out.raised();
  }
  return state;
}

TEST(EarlyTerminationTest, BothRulesTogetherStayWithinTheirError) {
  constexpr double kError = 1.0 / 255;
  RayMaker make(7);
  double worst = 0;
  for (int i = 0; i < 50'000; ++i) {
    Samples ray = i % 3 == 0 ? adversarial(make, make.unit()) : make.ray(80, 4);
    // Samples are often opaque. Some later samples matter more and some do not.
    for (std::size_t s = 0; s + 1 < ray.size() && i % 2 == 0; s += 2) ray[s].alpha = make.unit();
    const auto full = logs<double>(ray);
    const auto fast = terminated(ray, kError);
    for (const double background : {0.0, 1.0}) {
      const Rgb<double> difference = premultiplied(full) - premultiplied(fast) +
                                     Rgb<double>::Constant(background * (fast.alpha - full.alpha));
      worst = std::max(worst, difference.cwiseAbs().maxCoeff());
    }
  }
  EXPECT_LE(worst, kError);
  EXPECT_GT(worst, kError / 50) << "nothing was left out";
}

TEST(EarlyTerminationTest, BoundHoldsBehindAHundredThousandFaintSamples) {
  constexpr double kRounding = 1e-9;  // The error of 10^5 steps.
  for (const double more : {0.0, 1e-6, 1e-3, 0.1, 1.0, 5.0}) {
    Samples ray(5, {Rgb<double>::Zero(), 0.9, 2});
    ray.insert(ray.end(), 100'000, {Rgb<double>::Ones(), 1e-5, 2 + more});
    ImportanceState<double> state;
    for (std::size_t s = 0; s < 5; ++s) {
      composite_log(state, ray[s].rgb, ray[s].alpha, ray[s].importance);
    }
    const ImportanceState<double> stop = state;
    for (std::size_t s = 5; s < ray.size(); ++s) {
      composite_log(state, ray[s].rgb, ray[s].alpha, ray[s].importance);
    }
    const double colour = (premultiplied(state) - premultiplied(stop)).cwiseAbs().maxCoeff();
    const double through = std::exp(100'000 * std::log1p(-1e-5));
    EXPECT_LE(colour, remaining_change(stop.alpha, stop.importance, 2 + more) + kRounding) << more;
    const double tighter = remaining_change(stop.alpha, stop.importance, 2 + more, through);
    EXPECT_LE(colour, tighter + kRounding) << more;
    if (more >= 1e-3) {
      EXPECT_GE(colour, 0.9 * tighter) << more << ": the worst ray there is";
    }
    constexpr double kError = 1.0 / 255;
    const auto fast = terminated(ray, kError);
    EXPECT_LE((premultiplied(state) - premultiplied(fast)).cwiseAbs().maxCoeff(), kError) << more;
  }
}

/// An opaque start, then pairs of samples. A white sample is a little more important than all
/// samples before, and a black sample is a little more important than the white one. A program that
/// leaves out the white samples and takes the black ones adds up errors.
Samples staircase(RayMaker& make, double rise) {
  Samples ray(8, {Rgb<double>::Zero(), 0.9, 1});
  double importance = 1;
  for (int i = 0; i < 300; ++i) {
    const double alpha = make.below(2) == 0 ? 1 : make.unit();
    ray.push_back({Rgb<double>::Ones(), alpha, importance + 0.9 * rise});
    importance += 1.1 * rise;
    ray.push_back({Rgb<double>::Zero(), 1, importance});
  }
  return ray;
}

TEST(EarlyTerminationTest, ARayThatLeftSamplesOutDoesNotAlsoEndByTheTheorem) {
  constexpr double kError = 1.0 / 255;
  const Rgb<double> black = Rgb<double>::Zero();
  const Rgb<double> white = Rgb<double>::Ones();
  Samples ray{{black, 1, 1}};
  ray.push_back({white, 1, 1 + 0.3 * kError});  // The ray leaves this out and counts its error.
  ray.push_back({black, 1, 1 + 2 * kError});    // Too much for each of the rules.
  ray.push_back({white, 1, 1 + 2.9 * kError});  // The theorem alone would permit an end here.
  const auto full = logs<double>(ray);
  const auto fast = terminated(ray, kError);
  EXPECT_GT(full.rgb.x(), 1.1 * kError) << "what both rules together would lose";
  EXPECT_LT(fast.rgb.x(), full.rgb.x() - 0.2 * kError) << "nothing was left out";
  EXPECT_LE((premultiplied(full) - premultiplied(fast)).cwiseAbs().maxCoeff(), kError);
}

TEST(EarlyTerminationTest, LeavingOutSlightlyMoreImportantSamplesStaysWithinTheError) {
  constexpr double kError = 1.0 / 255;
  RayMaker make(8);
  double worst = 0;
  double naive = 0;
  for (int i = 0; i < 2'000; ++i) {
    const Samples ray = staircase(make, kError / 8 * std::pow(10.0, 2 * make.unit() - 1));
    const auto full = logs<double>(ray);
    const auto fast = terminated(ray, kError);
    worst = std::max(worst, (premultiplied(full) - premultiplied(fast)).cwiseAbs().maxCoeff());
    // Leaves out each sample that is at most error / 8 more important, without a count of the
    // errors.
    ImportanceState<double> state;
    for (const auto& sample : ray) {
      if (state.alpha > 1 - kError / 16 && sample.importance <= state.importance + kError / 8) {
        continue;
      }
      composite_log(state, sample.rgb, sample.alpha, sample.importance);
    }
    naive = std::max(naive, (premultiplied(full) - premultiplied(state)).cwiseAbs().maxCoeff());
  }
  EXPECT_LE(worst, kError);
  EXPECT_GT(naive, 10 * kError) << "without an account the errors add up, and this must show it";
}

/// Compares classify() with eqs. 6 to 8 in extended precision.
void expect_formula(std::uint32_t mask, const std::vector<PredicateWeight>& weights) {
  constexpr long double kRad = 0.017453292519943295769L;
  long double sum = 0;
  long double saturation = 0;
  long double linear = 0;
  std::complex<long double> pointer = 0;
  int count = 0;
  for (std::size_t j = 0; j < weights.size(); ++j) {
    if (((mask >> j) & 1U) == 0) continue;
    const long double impact = weights[j].impact;
    const long double coloured = impact * static_cast<long double>(weights[j].saturation);
    sum += impact;
    saturation += coloured;
    linear += coloured * static_cast<long double>(weights[j].hue_deg);
    pointer += std::polar(coloured, kRad * static_cast<long double>(weights[j].hue_deg));
    ++count;
  }
  const PredicateClass c = classify(mask, weights, HueMean::kCircular);
  constexpr double kDigits = 1e-13;
  const auto importance = static_cast<double>(count > 0 ? sum / count : 0);
  ASSERT_NEAR(c.importance, importance, kDigits * (1 + importance)) << mask;
  ASSERT_NEAR(c.saturation, static_cast<double>(sum > 0 ? saturation / sum : 0), kDigits) << mask;
  if (!(saturation > 0)) return;
  const auto hue = static_cast<double>(linear / saturation);
  ASSERT_NEAR(classify(mask, weights, HueMean::kLinear).hue_deg, hue, 360 * kDigits) << mask;
  // Pointers that nearly cancel have no usable direction.
  if (std::abs(pointer) < 1e-6L * saturation) return;
  const long double turned = static_cast<long double>(c.hue_deg) - std::arg(pointer) / kRad;
  ASSERT_LT(std::abs(std::remainder(static_cast<double>(turned), 360.0)), 1e-7) << mask;
  ASSERT_TRUE(c.hue_deg >= 0 && c.hue_deg < 360) << mask;
}

std::vector<PredicateWeight> random_weights(RayMaker& make, std::size_t n) {
  std::vector<double> kappas(n);
  double sum = 0;
  for (double& kappa : kappas) sum += kappa = make.below(5) == 0 ? 0 : make.unit();
  for (double& kappa : kappas) kappa /= sum > 0 ? sum : 1;
  auto weights = weights_of(kappas);
  for (auto& weight : weights) {
    weight.hue_deg = 359.99 * make.unit();
    weight.saturation = make.below(6) == 0 ? 0 : make.unit();
  }
  return weights;
}

TEST(PredicateClassTest, EveryMaskEqualsTheFormula) {
  RayMaker make(9);
  for (std::size_t n = 1; n <= 12; ++n) {
    const auto weights = random_weights(make, n);
    for (std::uint32_t mask = 0; mask < 1U << n; ++mask) expect_formula(mask, weights);
  }
  for (int i = 0; i < 20'000; ++i) {
    const auto mask = static_cast<std::uint32_t>(make.below(1U << 16) << 16 | make.below(1U << 16));
    expect_formula(mask, random_weights(make, 32));
  }
}

TEST(PredicateClassTest, EqualImportancesGiveExactlyOne) {
  for (std::size_t n = 1; n <= 32; ++n) {
    const auto weights = weights_of(std::vector<double>(n, 1.0 / static_cast<double>(n)));
    for (const std::uint32_t mask : {1U, 0xFFFFFFFFU >> (32 - n), 0x55555555U}) {
      if ((mask & (0xFFFFFFFFU >> (32 - n))) == 0) continue;
      EXPECT_EQ(classify(mask, weights, HueMean::kCircular).importance, 1) << n;
    }
  }
}

TEST(PredicateClassTest, OneImportanceOfOneAndTheRestZeroGiveTheSquareOfTheCount) {
  std::vector<double> kappas(32, 0);
  kappas[5] = 1;
  const auto weights = weights_of(kappas);
  EXPECT_EQ(classify(1U << 5, weights, HueMean::kCircular).importance, 1024);
  EXPECT_EQ(classify(0xFFFFFFFFU, weights, HueMean::kCircular).importance, 32);
  EXPECT_EQ(classify(1U << 6, weights, HueMean::kCircular).importance, 0) << "0 hides";
  EXPECT_EQ(classify(0, weights, HueMean::kCircular).importance, 0) << "nothing true hides";
}

double hue(std::vector<PredicateWeight> weights, HueMean how = HueMean::kCircular) {
  return classify((1U << weights.size()) - 1U, weights, how).hue_deg;
}

TEST(PredicateClassTest, HuesAreAveragedOnTheCircle) {
  const double across = hue({{1, 350, 1}, {1, 10, 1}});
  EXPECT_LT(std::min(across, 360 - across), 1e-12);
  EXPECT_NEAR(hue({{1, 350, 1}, {1, 10, 1}}, HueMean::kLinear), 180, 1e-12) << "as printed";
  EXPECT_NEAR(hue({{1, 20, 1}, {3, 40, 1}}), 35.04, 0.01);
  EXPECT_NEAR(hue({{1, 20, 1}, {3, 40, 1}}, HueMean::kLinear), 35, 1e-12);
  EXPECT_NEAR(hue({{1, 0, 1}, {3, 90, 1}}), 71.565, 0.001);
}

TEST(PredicateClassTest, HuesThatCancelOrHaveNoWeightAreDefined) {
  EXPECT_EQ(hue({{1, 30, 0.5}, {1, 210, 0.5}}), 30) << "the first of equals";
  EXPECT_EQ(hue({{1, 30, 0.5}, {1, 150, 0.5}, {1, 270, 0.5}}), 30);
  EXPECT_EQ(hue({{1, 77, 0}, {2, 120, 0}}), 0) << "no saturation, no hue";
  EXPECT_EQ(hue({{0, 77, 1}, {0, 120, 1}}), 0);
  EXPECT_EQ(
      classify(3, std::vector<PredicateWeight>{{1, 77, 0}, {2, 9, 0}}, HueMean::kLinear).hue_deg,
      0);
}

TEST(PredicateClassTest, ColoursFollowHsl) {
  const auto at = [](double hue, double s, double l) { return hsl(hsl_tint(hue, s), l); };
  EXPECT_TRUE(at(0, 1, 0.5).isApprox(Rgb<double>(1, 0, 0)));
  EXPECT_TRUE(at(120, 1, 0.5).isApprox(Rgb<double>(0, 1, 0)));
  EXPECT_TRUE(at(240, 1, 0.25).isApprox(Rgb<double>(0, 0, 0.5)));
  EXPECT_TRUE(at(60, 0.5, 0.5).isApprox(Rgb<double>(0.75, 0.75, 0.25)));
  EXPECT_TRUE(at(300, 1, 0.75).isApprox(Rgb<double>(1, 0.5, 1)));
  for (const double hue : {0.0, 123.0, 359.9}) {
    EXPECT_EQ(at(hue, 1, 0), Rgb<double>(0, 0, 0)) << "black has no colour";
    EXPECT_EQ(at(hue, 1, 1), Rgb<double>(1, 1, 1)) << "nor has white";
    EXPECT_EQ(at(hue, 0, 0.3), Rgb<double>::Constant(0.3));
  }
}

}  // namespace
}  // namespace nav::render::spec
