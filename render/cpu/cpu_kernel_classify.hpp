// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_sample.hpp"

/// Conversion of values to colour and extinction, as in TransferTable. See cpu_kernel.hpp for V and
/// for the files that may include this.
namespace nav::render {

/// Equal to spec::kMaxBowShare.
inline constexpr float kMarchMaxBowShare = 0.5F;
/// Values closer than this, in HU, are averaged instead of dividing differences of integrals.
inline constexpr float kCloseHu = 0.5F;

/// Post-classification.
template <class V, bool kWindows>
struct Table {
  using F = typename V::F;
  using I = typename V::I;

  const MarchInputs& in;

  struct Sample {
    F rgb[3];
    F tau;
    F importance;
  };

  /// Importance of the nearest entry. \p gradient, HU/mm, is used only with windows.
  F importance_at(F hu, F gradient) const {
    const F half = V::set(0.5F);
    const F held = V::min(V::max(hu, V::set(in.table_low_hu)), V::set(in.table_high_hu));
    I nearest = V::truncate(V::add(V::sub(held, V::set(in.table_low_hu)), half));
    if constexpr (kWindows) {
      const F row = V::min(V::mul(gradient, V::set(in.rows_per_gradient)),
                           V::set(static_cast<float>(in.table_rows - 1)));
      nearest = V::add(nearest, V::mul(V::truncate(V::add(row, half)), V::set_int(in.table_size)));
    }
    return V::load_float(in.importance, nearest);
  }

  /// Interpolated entry. Its importance is 1 unless with_importance.
  Sample at(F hu, F gradient, bool with_importance) const {
    const F x = V::sub(V::min(V::max(hu, V::set(in.table_low_hu)), V::set(in.table_high_hu)),
                       V::set(in.table_low_hu));
    const I i = V::truncate(x);
    const F w = V::sub(x, V::to_float(i));
    F value[4];
    F row = V::set(0.0F);
    if constexpr (kWindows) {
      row = V::min(V::mul(gradient, V::set(in.rows_per_gradient)),
                   V::set(static_cast<float>(in.table_rows - 1)));
      const F lower = V::min(V::floor(row), V::set(static_cast<float>(in.table_rows - 2)));
      const I start = V::add(V::mul(V::truncate(lower), V::set_int(in.table_size)), i);
      F above[4];
      V::lookup(in.table, start, w, value);
      V::lookup(in.table, V::add(start, V::set_int(in.table_size)), w, above);
      for (int c = 0; c < 4; ++c) {
        value[c] = Sampler<V>::lerp(value[c], above[c], V::sub(row, lower));
      }
    } else {
      V::lookup(in.table, i, w, value);
    }
    Sample s{{value[0], value[1], value[2]}, V::max(value[3], V::set(0.0F)), V::set(1.0F)};
    if (with_importance) s.importance = importance_at(hu, gradient);
    return s;
  }
};

/// Pre-integrated classification: TransferTable::mean().
template <class V>
struct Integrals {
  using F = typename V::F;
  using I = typename V::I;
  using M = typename V::M;
  using State = typename V::Integral;  ///< The integral up to a value and half of its derivative.

  const MarchInputs& in;

  void at(F hu, State& state) const {
    const F x = V::sub(hu, V::set(in.table_low_hu));
    const F one = V::set(1.0F);
    const F last = V::set(static_cast<float>(in.table_size - 1));
    const I i = V::truncate(V::add(V::min(V::max(x, V::set(-1.0F)), last), one));
    const F start = V::max(V::sub(V::to_float(i), one), V::set(0.0F));
    V::integral(in.integrals, i, V::sub(x, start), state);
  }

  static F twice(F x) { return V::add(x, x); }

  /// Integrals over an interval of values, and the length of the interval.
  struct Sums {
    F integral[4];
    F over;
  };

  void sum(F a_hu, F b_hu, F bow_hu, const State& a, const State& b, Sums& sums) const {
    const F nothing = V::set(0.0F);
    const F one = V::set(1.0F);
    const F change = V::sub(b_hu, a_hu);
    const M close = V::less(V::abs(change), V::set(kCloseHu));
    const F most = V::mul(V::abs(change), V::set(kMarchMaxBowShare));
    const F bow = V::max(V::min(bow_hu, most), V::sub(nothing, most));
    // Close values: their trapezoid is added with the weight of an interval of length 2. Otherwise
    // the quanta would be visible.
    const F sign = V::select(V::less(change, nothing), V::sub(nothing, one), one);
    const F even = V::mask(close, sign);
    const F lean = V::mask(V::negate(close), bow);
    V::change(a, b, twice(V::sub(even, lean)), twice(V::add(even, lean)), sums.integral);
    sums.over = V::add(change, twice(even));
  }

  /// Mean colour, weighted by extinction, and mean extinction per mm.
  void mean(const Sums& sums, F* rgb, F& tau) const {
    const F nothing = V::set(0.0F);
    const F one = V::set(1.0F);
    const F* integral = sums.integral;
    const F over = sums.over;
    // One division serves both quotients, because division is slow.
    const F product = V::mul(integral[3], over);
    const F per_product = V::div(one, V::max(product, V::set(1e-20F)));
    const F per_integral = V::mul(per_product, over);
    for (int c = 0; c < 3; ++c) {
      rgb[c] = V::max(nothing, V::min(one, V::mul(integral[c], per_integral)));
    }
    const F mean = V::mul(V::mul(integral[3], per_product), integral[3]);
    tau = V::mask(V::less(nothing, product), V::mul(mean, V::set(in.quantum)));
  }
};

/// The cutaway on a packet of rays: spec::occlusion(), visibility() and faded().
template <class V>
struct Fading {
  using F = typename V::F;
  using M = typename V::M;

  F t1;
  F t2;
  F per_transition;
  F per_overlay;
  F share;
  F add_low;
  F add_high;

  Fading(const MarchInputs& in, const RayPacket& rays, int lane)
      : t1(V::load(rays.t1 + lane)),
        t2(V::load(rays.t2 + lane)),
        per_transition(V::load(rays.per_transition + lane)),
        per_overlay(V::set(in.per_overlay)),
        share(V::set(in.fade_share)),
        add_low(V::set(in.fade_low)),
        add_high(V::set(in.fade_high)) {}

  /// The fading of the rays of other lanes; V must pack.
  [[nodiscard]] Fading pick(typename V::I lanes) const {
    Fading picked = *this;
    picked.t1 = V::pick(t1, lanes);
    picked.t2 = V::pick(t2, lanes);
    picked.per_transition = V::pick(per_transition, lanes);
    return picked;
  }

  static F clamp01(F x) { return V::max(V::set(0.0F), V::min(V::set(1.0F), x)); }

  /// Share of its opacity that a sample of an importance keeps at t, in cells.
  F visibility(F importance, F t) const {
    const F one = V::set(1.0F);
    const F outer = clamp01(V::mul(V::sub(t2, t), per_transition));
    const F inner = clamp01(V::mul(V::sub(t1, t), per_overlay));
    const F omega = V::mul(V::set(0.5F), V::add(outer, inner));
    const F own = V::max(V::sub(V::add(importance, importance), one), V::set(0.0F));
    // Thresholds by importance: x · 1 + 0 is x to the last bit.
    const F low = V::madd(own, share, add_low);
    const F high = V::madd(importance, share, add_high);
    const F width = V::max(V::sub(high, low), V::set(1e-20F));
    const F ramp = V::div(V::sub(high, omega), width);
    const F hidden = V::select(V::not_less(omega, high), V::set(0.0F), ramp);
    return V::select(V::not_less(low, omega), one, hidden);
  }

  static F faded(F tau, F visible) {
    const F one = V::set(1.0F);
    const F none = V::set(0.0F);
    const M partly = V::both(V::less(none, visible), V::less(visible, one));
    const F ends = V::select(V::less(none, visible), tau, none);
    if (!V::any(V::both(partly, V::less(none, tau)))) return ends;
    const F dim = V::sub(none, V::log1p(V::sub(none, V::mul(visible, V::one_minus_exp(tau)))));
    return V::select(partly, dim, ends);
  }
};

}  // namespace nav::render
