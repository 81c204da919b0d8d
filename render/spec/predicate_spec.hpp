// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

/// The one specification of classification and compositing by predicates that all engines share
/// (Schulte zu Berge et al. 2014 §3.4 and appendix, after De Moura Pinto and Freitas 2010), with
/// corrections. ray_spec.hpp defines the positions of the samples; predicate_scene.hpp defines a
/// sample.
///
/// Mask. Bit j is set where predicate j is true. n is the number of predicates of the histogram.
/// Impact of predicate j: (n kappa_j)².
/// Importance (Eq. 6): the mean impact of the predicates that are true. If no predicate is true, or
/// the mean is 0, the sample is invisible, whatever its opacity.
/// Saturation (Eq. 8): the mean saturation, weighted by impact.
/// Hue: the circular mean, weighted by impact · saturation. The paper's linear mean is an option.
/// If all weights are 0, the hue is 0. If the weights cancel on the circle, the hue is that of the
/// greatest weight; among equal weights, the first.
/// Colour: HSL with the intensity as luminance. Opacity: see predicate_scene.hpp.
namespace nav::render::spec {

template <class S>
using Rgb = Eigen::Matrix<S, 3, 1>;

enum class HueMean {
  kCircular,
  kLinear,  ///< The paper's linear mean: 350° and 10° give 180°.
};

/// The contribution of one predicate to Eqs. 6 to 8.
struct PredicateWeight {
  double impact;      ///< (n kappa)².
  double hue_deg;     ///< [0, 360).
  double saturation;  ///< [0, 1].
};

inline double impact_of(double kappa, std::size_t n) {
  const double x = static_cast<double>(n) * kappa;
  return x * x;
}

struct PredicateClass {
  double importance = 0;  ///< kappa(s); 0 means invisible.
  double hue_deg = 0;
  double saturation = 0;
};

/// Weighted mean hue, degrees in [0, 360). Weights >= 0, in the order of the predicates.
template <class Weight, class Hue>
double mean_hue(std::size_t n, const Weight& weight, const Hue& hue_deg, HueMean how) {
  constexpr double kRadPerDeg = M_PI / 180;
  double x = 0;
  double y = 0;
  double sum = 0;
  double linear = 0;
  double most = 0;
  double hue_of_most = 0;
  for (std::size_t j = 0; j < n; ++j) {
    const double w = weight(j);
    if (!(w > 0)) continue;
    x += w * std::cos(hue_deg(j) * kRadPerDeg);
    y += w * std::sin(hue_deg(j) * kRadPerDeg);
    sum += w;
    linear += w * hue_deg(j);
    if (w > most) {
      most = w;
      hue_of_most = hue_deg(j);
    }
  }
  if (!(sum > 0)) return 0;
  if (how == HueMean::kLinear) return linear / sum;
  constexpr double kCancelled = 1e-9;  // Far above the rounding error of 32 terms.
  if (std::hypot(x, y) <= kCancelled * sum) return hue_of_most;
  const double hue = std::atan2(y, x) / kRadPerDeg;
  const double positive = hue < 0 ? hue + 360 : hue;
  return positive < 360 ? positive : 0;
}

/// Evaluates Eqs. 6 to 8 for a mask.
inline PredicateClass classify(std::uint32_t mask, std::span<const PredicateWeight> predicates,
                               HueMean how) {
  double impact = 0;
  double saturation = 0;
  int count = 0;
  const auto is = [&](std::size_t j) { return ((mask >> j) & 1U) != 0; };
  for (std::size_t j = 0; j < predicates.size(); ++j) {
    if (!is(j)) continue;
    ++count;
    impact += predicates[j].impact;
    saturation += predicates[j].impact * predicates[j].saturation;
  }
  if (!(impact > 0)) return {};
  return {impact / count,
          mean_hue(
              predicates.size(),
              [&](std::size_t j) {
                return is(j) ? predicates[j].impact * predicates[j].saturation : 0.0;
              },
              [&](std::size_t j) { return predicates[j].hue_deg; }, how),
          std::min(saturation / impact, 1.0)};
}

/// The part that HSL adds to the grey of the luminance: rgb = L + (1 - |2 L - 1|) · tint.
inline Rgb<double> hsl_tint(double hue_deg, double saturation) {
  const double sector = hue_deg / 60;
  const auto pure = [&](double shift) {
    return std::clamp(std::abs(std::fmod(sector + shift, 6.0) - 3) - 1, 0.0, 1.0);
  };
  return saturation * (Rgb<double>(pure(0), pure(4), pure(2)) - Rgb<double>::Constant(0.5));
}

template <class S>
Rgb<S> hsl(const Rgb<S>& tint, S luminance) {
  const S chroma = S(1) - std::abs(S(2) * luminance - S(1));
  return Rgb<S>::Constant(luminance) + chroma * tint;
}

/// Accumulated light of a ray, front to back. The colour is not premultiplied.
template <class S>
struct ImportanceState {
  Rgb<S> rgb = Rgb<S>::Zero();
  S alpha = S(0);
  S importance = S(0);  ///< Log form: I. Weight form: W = exp(I - I_max).
};

/// Share of the accumulated colour that a sample replaces, with a = m · alpha: RENDERING.md b.1.
template <class S>
S replaced(S a, S alpha_s) {
  return (S(1) - a) * alpha_s / (a + (S(1) - a) * alpha_s);
}

/// Composites one sample by Eqs. 10 to 12, corrected and without a division by the opacity;
/// importance >= 0. Returns the replaced share.
template <class S>
S composite_log(ImportanceState<S>& state, const Rgb<S>& rgb, S alpha_s, S importance) {
  if (!(alpha_s > S(0))) return S(0);
  const S more = std::max(S(0), importance - state.importance);
  const S beta = replaced(std::min(state.alpha, std::exp(-more)), alpha_s);
  state.rgb += beta * (rgb - state.rgb);
  state.alpha += (S(1) - state.alpha) * alpha_s;
  if (importance > state.importance) {
    // The argument of the logarithm, alpha_s + (1 - alpha_s) exp(-more), lies in (0, 1].
    state.importance = importance + std::log1p((S(1) - alpha_s) * std::expm1(-more));
  }
  return beta;
}

/// Composites one sample as composite_log() does, with weights W = exp(I - I_max) and w in (0, 1].
/// It needs no exponential and no logarithm. In single precision it requires weights_suffice().
template <class S>
S composite_weight(ImportanceState<S>& state, const Rgb<S>& rgb, S alpha_s, S w) {
  if (!(alpha_s > S(0))) return S(0);
  const S a = w <= state.importance ? state.alpha : std::min(state.alpha, state.importance / w);
  const S beta = replaced(a, alpha_s);
  state.rgb += beta * (rgb - state.rgb);
  state.alpha += (S(1) - state.alpha) * alpha_s;
  state.importance =
      std::max(state.importance, state.importance + alpha_s * (w - state.importance));
  return beta;
}

/// True when single precision can hold the weights of all importances > 0.
inline bool weights_suffice(double least, double greatest) { return greatest - least < 80; }

/// Plain over compositing. The two functions above reduce to it when all importances are equal.
template <class S>
S composite_over(ImportanceState<S>& state, const Rgb<S>& rgb, S alpha_s) {
  if (!(alpha_s > S(0))) return S(0);
  const S beta = replaced(state.alpha, alpha_s);
  state.rgb += beta * (rgb - state.rgb);
  state.alpha += (S(1) - state.alpha) * alpha_s;
  return beta;
}

/// Upper bound of the remaining change of the colour (premultiplied or not), the opacity, and the
/// pixel over any background, when no later sample has an importance above greatest_to_come:
/// RENDERING.md b.3. Colours in [0, 1].
template <class S>
S remaining_change(S alpha, S importance, S greatest_to_come) {
  return S(1) - alpha * std::exp(-std::max(S(0), greatest_to_come - importance));
}

/// Tighter bound for the premultiplied colour, when at least the share `transmitted` of the light
/// passes all later samples.
template <class S>
S remaining_change(S alpha, S importance, S greatest_to_come, S transmitted) {
  const S kept = std::exp(-std::max(S(0), greatest_to_come - importance));  // W_i / W_bar
  const S ratio = kept / (S(1) - (S(1) - kept) * transmitted);              // >= W_i / W_N
  const S alpha_end = S(1) - (S(1) - alpha) * transmitted;                  // >= alpha_N
  return std::max(alpha * (S(1) - ratio), alpha_end - alpha * ratio);
}

}  // namespace nav::render::spec
