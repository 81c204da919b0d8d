// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_part.hpp"

/// Means of the midpoints of parts whose visibility or importance varies. See cpu_kernel.hpp for V
/// and for the files that may include this.
namespace nav::render {

/// kFaded: with the fade of the cutaway.
template <class V, bool kWindows>
struct PartSteps {
  using F = typename V::F;
  using I = typename V::I;
  using M = typename V::M;
  using Part = CellPart<V>;
  using Colour = CellColour<V>;
  using Sample = typename Table<V, kWindows>::Sample;

  const Table<V, kWindows>& table;
  const Fading<V>& fading;

  /// Mean of a part that is one sample.
  template <bool kFaded>
  Colour of(const Part& part, const Sample& s) const {
    Colour sum = nothing();
    for (int j = 0; j < kMarchFadeSteps; ++j) {
      add(s, kFaded ? faded(fading, s, time(part, j)) : s.tau, sum);
    }
    return mean(sum);
  }

  /// Mean of a part whose values run linearly from its begin to its end.
  template <bool kFaded>
  Colour between(const Part& part) const {
    Colour sum = nothing();
    for (int j = 0; j < kMarchFadeSteps; ++j) {
      const Sample s = table.at(value(part, j), V::set(0.0F), true);
      add(s, kFaded ? faded(fading, s, time(part, j)) : s.tau, sum);
    }
    return mean(sum);
  }

  /// Mean as in between(), for few lanes with all their midpoints side by side; 0 or 1 in the other
  /// lanes.
  template <bool kFaded>
  Colour packed(const Part& part, M needed) const {
    constexpr int kRoom = (kMarchFadeSteps + 1) * V::kLanes;
    alignas(64) float hu[kRoom];
    alignas(64) float t[kRoom];
    alignas(64) float lane[kRoom];
    alignas(64) float found[5][kRoom];  // Colour, extinction, importance.
    const int lanes = V::count(needed);
    for (int j = 0; j < kMarchFadeSteps; ++j) {
      V::pack(hu + j * lanes, needed, value(part, j));
      if constexpr (kFaded) V::pack(t + j * lanes, needed, time(part, j));
      if constexpr (kFaded) V::pack(lane + j * lanes, needed, V::lane_numbers());
    }
    for (int first = 0; first < kMarchFadeSteps * lanes; first += V::kLanes) {
      const Sample s = table.at(V::load(hu + first), V::set(0.0F), true);
      F tau = s.tau;
      if constexpr (kFaded) {
        const Fading<V> picked = fading.pick(V::truncate(V::load(lane + first)));
        tau = faded(picked, s, V::load(t + first));
      }
      for (int c = 0; c < 3; ++c) V::store(found[c] + first, s.rgb[c]);
      V::store(found[3] + first, tau);
      V::store(found[4] + first, s.importance);
    }
    Colour sum = nothing();
    for (int j = 0; j < kMarchFadeSteps; ++j) {
      const auto at = [&](int i) { return V::unpack(found[i] + j * lanes, needed); };
      add({{at(0), at(1), at(2)}, at(3), at(4)}, at(3), sum);
    }
    return mean(sum);
  }

 private:
  static F weight(int j) { return V::set((static_cast<float>(j) + 0.5F) / kMarchFadeSteps); }
  static F value(const Part& part, int j) {
    return Sampler<V>::lerp(part.v_a, part.v_b, weight(j));
  }
  static F time(const Part& part, int j) { return Sampler<V>::lerp(part.t_a, part.t_b, weight(j)); }

  static F faded(const Fading<V>& fading, const Sample& s, F t) {
    return Fading<V>::faded(s.tau, fading.visibility(s.importance, t));
  }

  static Colour nothing() {
    return {{V::set(0.0F), V::set(0.0F), V::set(0.0F)}, V::set(0.0F), V::set(0.0F)};
  }
  static void add(const Sample& s, F tau, Colour& sum) {
    for (int i = 0; i < 3; ++i) sum.rgb[i] = V::madd(tau, s.rgb[i], sum.rgb[i]);
    sum.tau = V::add(sum.tau, tau);
    sum.importance = V::madd(tau, s.importance, sum.importance);
  }
  static Colour mean(Colour sum) {
    const F per_sum = V::div(V::set(1.0F), V::max(sum.tau, V::set(1e-20F)));
    for (int i = 0; i < 3; ++i) sum.rgb[i] = V::mul(sum.rgb[i], per_sum);
    sum.importance =
        V::select(V::less(V::set(0.0F), sum.tau), V::mul(sum.importance, per_sum), V::set(1.0F));
    sum.tau = V::mul(sum.tau, V::set(1.0F / kMarchFadeSteps));
    return sum;
  }
};

}  // namespace nav::render
