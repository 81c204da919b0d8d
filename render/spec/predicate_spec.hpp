// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

/// Classification and compositing of predicates (Schulte zu Berge et al. 2014 §3.4 and appendix,
/// after De Moura Pinto and Freitas 2010), corrected: the one specification that the engines share.
/// ray_spec.hpp says where samples lie; predicate_scene.hpp what a sample is.
///
/// Mask. Bit j is set where predicate j is true. n: the number of predicates of the histogram.
/// Impact of predicate j: (n kappa_j)².
/// Importance (Eq. 6): the mean impact of the predicates that are true. No predicate true, or a
/// mean of 0: the sample is invisible, whatever its opacity.
/// Saturation (Eq. 8): the mean saturation weighted by impact. Hue: the mean weighted by impact ·
/// saturation, on the circle; the paper's linear mean as an option. No weight: hue 0. Weights that
/// cancel on the circle: the hue of the greatest weight, the first of equals.
/// Colour: HSL with the intensity as luminance. Opacity: predicate_scene.hpp.
namespace nav::render::spec {

template <class S>
using Rgb = Eigen::Matrix<S, 3, 1>;

enum class HueMean {
  kCircular,
  kLinear,  ///< As the paper prints it: 350° and 10° give 180°.
};

/// One predicate's part in Eqs. 6 to 8.
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
  double importance = 0;  ///< kappa(s); 0: invisible.
  double hue_deg = 0;
  double saturation = 0;
};

/// Hue of weighted hues; weights >= 0, in the order of predicates.
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
  constexpr double kCancelled = 1e-9;  // Far above the rounding of 32 terms.
  if (std::hypot(x, y) <= kCancelled * sum) return hue_of_most;
  const double hue = std::atan2(y, x) / kRadPerDeg;
  const double positive = hue < 0 ? hue + 360 : hue;
  return positive < 360 ? positive : 0;
}

/// Eqs. 6 to 8 for a mask.
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

/// What HSL adds to the grey of the luminance: rgb = L + (1 - |2 L - 1|) · tint.
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

/// Light on a ray so far, front to back. Colour is not premultiplied.
template <class S>
struct ImportanceState {
  Rgb<S> rgb = Rgb<S>::Zero();
  S alpha = S(0);
  S importance = S(0);  ///< Log form: I. Weight form: W = exp(I - I_max).
};

/// Share of what was there that a sample replaces, given a = m · alpha: RENDERING.md b.1.
template <class S>
S replaced(S a, S alpha_s) {
  return (S(1) - a) * alpha_s / (a + (S(1) - a) * alpha_s);
}

/// Eqs. 10 to 12, corrected and without a division by the opacity; importance >= 0. Returns the
/// share that was replaced.
template <class S>
S composite_log(ImportanceState<S>& state, const Rgb<S>& rgb, S alpha_s, S importance) {
  if (!(alpha_s > S(0))) return S(0);
  const S more = std::max(S(0), importance - state.importance);
  const S beta = replaced(std::min(state.alpha, std::exp(-more)), alpha_s);
  state.rgb += beta * (rgb - state.rgb);
  state.alpha += (S(1) - state.alpha) * alpha_s;
  if (importance > state.importance) {
    // log(alpha_s + (1 - alpha_s) exp(-more)), whose argument lies in (0, 1].
    state.importance = importance + std::log1p((S(1) - alpha_s) * std::expm1(-more));
  }
  return beta;
}

/// The same by weights W = exp(I - I_max), w in (0, 1]: no exponential and no logarithm. For single
/// precision while weights_suffice().
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

/// Whether single precision can hold the weights of all importances > 0.
inline bool weights_suffice(double least, double greatest) { return greatest - least < 80; }

/// Plain over, which the two above become when all importances are equal.
template <class S>
S composite_over(ImportanceState<S>& state, const Rgb<S>& rgb, S alpha_s) {
  if (!(alpha_s > S(0))) return S(0);
  const S beta = replaced(state.alpha, alpha_s);
  state.rgb += beta * (rgb - state.rgb);
  state.alpha += (S(1) - state.alpha) * alpha_s;
  return beta;
}

/// How far colour (premultiplied or not), opacity, and the pixel over any background may still move
/// when no sample to come has more than an importance: RENDERING.md b.3. Colours in [0, 1].
template <class S>
S remaining_change(S alpha, S importance, S greatest_to_come) {
  return S(1) - alpha * std::exp(-std::max(S(0), greatest_to_come - importance));
}

/// The same, tighter, when at least the share `transmitted` of light passes all that is to come:
/// bounds the premultiplied colour.
template <class S>
S remaining_change(S alpha, S importance, S greatest_to_come, S transmitted) {
  const S kept = std::exp(-std::max(S(0), greatest_to_come - importance));  // W_i / W_bar
  const S ratio = kept / (S(1) - (S(1) - kept) * transmitted);              // >= W_i / W_N
  const S alpha_end = S(1) - (S(1) - alpha) * transmitted;                  // >= alpha_N
  return std::max(alpha * (S(1) - ratio), alpha_end - alpha * ratio);
}

}  // namespace nav::render::spec
