// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu_kernel_classify.hpp"
#include "render/cpu_kernel_leap.hpp"
#include "render/cpu_kernel_segment.hpp"
#include "render/cpu_kernel_shade.hpp"

/// The march of ray_spec.hpp in single precision, written once for any number of lanes. V supplies
/// the arithmetic: V::F (floats), V::I (32-bit integers), V::M (lane mask), V::Integral, of
/// V::kLanes lanes. Include only from the files that define a V in an unnamed namespace: then every
/// instance has internal linkage and stays in the file whose instruction set it was compiled for.
namespace nav::render {

/// One variant of the march: what it does not need is not in its code. What a lane computes never
/// depends on the other lanes, so that skipping stays bit-identical.
template <class V, MarchClassify kClassify, MarchShade kShade, bool kFade, bool kAdaptive>
class Marcher {
  using F = typename V::F;
  using I = typename V::I;
  using M = typename V::M;
  static constexpr bool kPre = kClassify == MarchClassify::kPreIntegrated;
  static constexpr bool kWindows = kClassify == MarchClassify::kWindows;

 public:
  Marcher(const MarchInputs& inputs, RayPacket& rays, int lane, MarchCounts& counts)
      : in_(inputs),
        rays_(rays),
        lane_(lane),
        counts_(counts),
        sampler_(inputs, rays, lane),
        table_{inputs},
        integrals_{inputs},
        fading_(inputs, rays, lane),
        begin_(V::load(rays.begin + lane)),
        end_(V::load(rays.end + lane)),
        alpha_(V::load(rays.alpha + lane)) {
    for (int c = 0; c < 3; ++c) rgb_[c] = V::load(rays.rgb[c] + lane);
  }

  void march() {
    const F opaque = V::set(in_.opaque_at);
    F cell = V::floor(begin_);
    M active = V::both(V::less(begin_, end_), V::less(alpha_, opaque));
    if (!V::any(active)) return;
    Leaper<V, kPre, kFade> leaper(sampler_, rays_, lane_, cell);
    Segments<V> segments(sampler_, cell);
    const bool skipping = in_.brick_leap != nullptr;
    M fresh = active;  // Lanes whose value at the begin of their cell is not known.
    // Lanes enter bricks one after the other: a look for each would cost more than to march on a
    // little through what is empty, which changes nothing.
    for (int until_look = 0; true; --until_look) {
      if (skipping && until_look == 0) {
        if (leaper.leap(cell, end_, active, fresh)) {
          active = V::both(active, V::less(cell, end_));
          if (!V::any(active)) break;
        }
        until_look = in_.cells_per_look;
      }
      if constexpr (kAdaptive) {
        const M single = kFade ? V::less(cell, fading_.t2) : V::none();
        cells_ = segments.cells(cell, begin_, end_, active, single);
      }
      add_cell(cell, active, fresh);
      fresh = V::none();
      cell = V::add(cell, cells_);
      active = V::both(active, V::both(V::less(cell, end_), V::less(alpha_, opaque)));
      if (!V::any(active)) break;
    }
    V::store(rays_.alpha + lane_, alpha_);
    for (int c = 0; c < 3; ++c) V::store(rays_.rgb[c] + lane_, rgb_[c]);
  }

 private:
  /// A cell or the part of one between the events of the ray.
  struct Part {
    F cell;
    F t_a;  ///< In cells from the ray's base.
    F t_b;
    F v_a;  ///< HU.
    F v_b;
    F bow;  ///< HU; spec::bow_of().
    M active;
  };
  struct Classified {
    F rgb[3];
    F tau;
    F importance;  ///< Only where it matters.
  };

  /// How the cutaway treats a part; ray_spec.hpp, "Cutaway".
  struct Fade {
    M before;   ///< In front of T2.
    M varies;   ///< Of these, lanes that are a mean of midpoints.
    F visible;  ///< Mean of the visibilities at the ends; 1 in lanes not in front.
  };

  void add_cell(F cell, M active, M fresh) {
    const F next = V::add(cell, cells_);
    Part part{cell, V::max(cell, begin_), V::min(next, end_), {}, {}, V::set(0.0F), active};
    counts_.samples += static_cast<std::uint64_t>(V::count(active));
    if constexpr (kPre) {
      add_pre_integrated(part, next, fresh);
    } else {
      part.v_a = part.v_b = sampler_.value(cell);
      if (!may_show(part)) return;
      F gradient = V::set(0.0F);
      if constexpr (kWindows) {
        counts_.window_gradients += static_cast<std::uint64_t>(V::count(active));
        sampler_.gradient(cell, active, gradient_);
        gradient = Sampler<V>::length(gradient_);
      }
      if (find_fade(part, gradient, false)) classify_and_blend(part, gradient);
    }
  }

  /// The values at the two lattice points of the cell; the front one is that at the back of the
  /// cell before.
  void add_pre_integrated(Part& part, F next, M fresh) {
    if (V::any(fresh)) {
      // The same value as before in the other lanes.
      front_ = sampler_.value(part.cell);
      front_classified_ = front_faded_ = false;
      counts_.samples += static_cast<std::uint64_t>(V::count(V::both(fresh, part.active)));
    }
    const F v0 = front_;
    const F v1 = sampler_.value(next);
    const M cut_a = V::less(part.cell, part.t_a);
    const M cut_b = V::less(part.t_b, next);
    const F rise = V::sub(v1, v0);
    const M cut = V::either(cut_a, cut_b);
    part.v_a = v0;
    part.v_b = v1;
    if (V::any(cut)) {
      part.v_a = V::select(cut_a, V::madd(V::sub(part.t_a, part.cell), rise, v0), v0);
      part.v_b = V::select(cut_b, V::madd(V::sub(part.t_b, part.cell), rise, v0), v1);
    }
    M bowed = V::both(V::negate(cut), V::less(V::set(1.5F), part.cell));
    if constexpr (kAdaptive) bowed = V::both(bowed, V::less(cells_, V::set(1.5F)));
    set_before(part.cell, V::both(part.active, bowed), fresh);
    const F rise_before = V::sub(v0, before_);
    part.bow = V::mask(bowed, V::mul(V::sub(rise_before, rise), V::set(1.0F / 12)));
    before_ = v0;
    if constexpr (kAdaptive) before_at_ = part.cell;
    front_ = v1;
    if (!may_show(part)) {
      front_classified_ = front_faded_ = false;
      return;
    }
    const bool begins_inside = V::any(V::both(part.active, cut_a));
    if (!find_fade(part, V::set(0.0F), front_faded_ && !begins_inside)) {
      front_classified_ = false;
      return;
    }
    if (!front_classified_ || begins_inside) {
      integrals_.at(part.v_a, ends_[front_end_]);
    }
    integrals_.at(part.v_b, ends_[1 - front_end_]);
    classify_and_blend(part, V::set(0.0F));
    // A lane cut at its back ends there, so that no lane that goes on has another value there.
    front_end_ = 1 - front_end_;
    front_classified_ = true;
  }

  /// Makes before_ the value at the lattice point in front of a cell, where that is needed.
  void set_before(F cell, M needed, M fresh) {
    const F there = V::sub(cell, V::set(1.0F));
    M unknown = V::both(needed, fresh);
    if constexpr (kAdaptive) {
      unknown = V::both(needed, V::either(fresh, V::less(before_at_, there)));
    }
    if (!V::any(unknown)) return;
    before_ = V::select(unknown, sampler_.value(there), before_);
    counts_.samples += static_cast<std::uint64_t>(V::count(unknown));
  }

  [[nodiscard]] bool may_show(const Part& part) const {
    const F most = V::max(part.v_a, part.v_b);
    return V::any(V::both(part.active, V::less(V::set(in_.invisible_up_to_hu), most)));
  }

  /// Sets fade_; false: the cutaway hides the part in every lane. goes_on: the part begins where
  /// the last one ended.
  bool find_fade([[maybe_unused]] const Part& part, [[maybe_unused]] F gradient,
                 [[maybe_unused]] bool goes_on) {
    if constexpr (kFade) {
      fade_.before = V::both(part.active, V::less(part.t_a, fading_.t2));
      front_faded_ = fades_ = V::any(fade_.before);
      if (!fades_) return true;
      counts_.faded += static_cast<std::uint64_t>(V::count(fade_.before));
      const F i_b = table_.importance_at(part.v_b, gradient);
      F visible_a = front_visible_;
      if (!goes_on) {
        const F i_a = kPre ? table_.importance_at(part.v_a, gradient) : i_b;
        visible_a = fading_.visibility(i_a, part.t_a);
      }
      const F visible_b = front_visible_ = fading_.visibility(i_b, part.t_b);
      fade_.varies = V::both(fade_.before, apart(visible_a, visible_b));
      fade_.visible = V::select(fade_.before, mean(visible_a, visible_b), V::set(1.0F));
      return V::any(V::both(part.active, V::less(V::set(0.0F), fade_.visible)));
    }
    return true;
  }

  static M apart(F a, F b) { return V::less(V::set(kMarchFadeVaries), V::abs(V::sub(a, b))); }
  static F mean(F a, F b) { return V::mul(V::set(0.5F), V::add(a, b)); }

  void classify_and_blend(const Part& part, F gradient) {
    Classified c = plain(part, gradient);
    if constexpr (kFade) {
      if (fades_) {
        c.tau = Fading<V>::faded(c.tau, fade_.visible);
        if (V::any(fade_.varies)) {
          const Classified mean = steps<true>(part, gradient);
          for (int i = 0; i < 3; ++i) c.rgb[i] = V::select(fade_.varies, mean.rgb[i], c.rgb[i]);
          c.tau = V::select(fade_.varies, mean.tau, c.tau);
          c.importance = V::select(fade_.varies, mean.importance, c.importance);
        }
      }
    }
    blend(part, c);
  }

  [[nodiscard]] bool needs_importance() const {
    return kShade != MarchShade::kNone && in_.emphasis > 0;
  }

  Classified plain(const Part& part, F gradient) const {
    Classified c;
    c.importance = V::set(1.0F);
    if constexpr (kPre) {
      integrals_.mean(part.v_a, part.v_b, part.bow, ends_[front_end_], ends_[1 - front_end_], c.rgb,
                      c.tau);
    } else {
      const auto s = table_.at(part.v_a, gradient, needs_importance());
      for (int i = 0; i < 3; ++i) c.rgb[i] = s.rgb[i];
      c.tau = s.tau;
      c.importance = s.importance;
    }
    return c;
  }

  /// The mean of the equidistant midpoints of a part, faded or not.
  template <bool kFaded>
  Classified steps(const Part& part, F gradient) const {
    Classified c{{V::set(0.0F), V::set(0.0F), V::set(0.0F)}, V::set(0.0F), V::set(0.0F)};
    typename Table<V, kWindows>::Sample s;
    if constexpr (!kPre) s = table_.at(part.v_a, gradient, true);
    for (int j = 0; j < kMarchFadeSteps; ++j) {
      const F w = V::set((static_cast<float>(j) + 0.5F) / kMarchFadeSteps);
      if constexpr (kPre) s = table_.at(Sampler<V>::lerp(part.v_a, part.v_b, w), gradient, true);
      F tau = s.tau;
      if constexpr (kFaded) {
        const F t = Sampler<V>::lerp(part.t_a, part.t_b, w);
        tau = Fading<V>::faded(tau, fading_.visibility(s.importance, t));
      }
      for (int i = 0; i < 3; ++i) c.rgb[i] = V::madd(tau, s.rgb[i], c.rgb[i]);
      c.tau = V::add(c.tau, tau);
      c.importance = V::madd(tau, s.importance, c.importance);
    }
    const F nothing = V::set(0.0F);
    const F per_sum = V::div(V::set(1.0F), V::max(c.tau, V::set(1e-20F)));
    for (int i = 0; i < 3; ++i) c.rgb[i] = V::mul(c.rgb[i], per_sum);
    c.importance = V::select(V::less(nothing, c.tau), V::mul(c.importance, per_sum), V::set(1.0F));
    c.tau = V::mul(c.tau, V::set(1.0F / kMarchFadeSteps));
    return c;
  }

  void blend(const Part& part, Classified& c) {
    const F length = V::sub(part.t_b, part.t_a);
    const F depth = V::mul(V::mul(c.tau, V::set(in_.step_mm)), length);
    const F opacity = V::one_minus_exp(V::max(depth, V::set(0.0F)));
    const F weight = V::mask(part.active, V::mul(opacity, V::sub(V::set(1.0F), alpha_)));
    if constexpr (kShade != MarchShade::kNone) shade(part, c, weight);
    for (int i = 0; i < 3; ++i) rgb_[i] = V::madd(weight, c.rgb[i], rgb_[i]);
    alpha_ = V::add(alpha_, weight);
  }

  void shade(const Part& part, Classified& c, F weight) {
    M shaded = V::less(V::set(in_.min_shaded_weight), weight);
    if (!V::any(shaded)) return;
    F share = V::set(1.0F);
    if (in_.emphasis > 0) {
      const F unimportant = V::sub(V::set(1.0F), importance_of(part, c, shaded));
      share = V::sub(V::set(1.0F), V::mul(V::set(in_.emphasis), unimportant));
      shaded = V::both(shaded, V::less(V::set(0.0F), share));
      if (!V::any(shaded)) return;
    }
    if constexpr (kPre) {
      shade_places(part.cell, c, weight, share, shaded);
    } else {
      counts_.gradients += static_cast<std::uint64_t>(V::count(shaded));
      if constexpr (!kWindows) sampler_.gradient(part.cell, shaded, gradient_);
      F full[3] = {c.rgb[0], c.rgb[1], c.rgb[2]};
      Shader<V, kShade>{sampler_}.shade(gradient_, share, full);
      for (int i = 0; i < 3; ++i) c.rgb[i] = V::select(shaded, full[i], c.rgb[i]);
    }
  }

  /// The mean of the shades at spec::shades_of() places of each lane's cell.
  void shade_places(F cell, Classified& c, F weight, F share, M shaded) {
    const F one = V::set(1.0F);
    const F half = V::set(0.5F);
    F wanted =
        V::mul(V::set(in_.shades_per_root), V::sqrt(V::mul(V::max(weight, V::set(0.0F)), cells_)));
    wanted = V::min(V::floor(V::add(wanted, half)), V::set(in_.most_shades));
    const F per = V::div(one, V::max(one, wanted));
    const F apart = V::mul(cells_, per);
    F sum[3] = {V::set(0.0F), V::set(0.0F), V::set(0.0F)};
    F place = half;
    M open = shaded;
    do {
      counts_.gradients += static_cast<std::uint64_t>(V::count(open));
      sampler_.gradient(V::madd(apart, place, cell), open, gradient_);
      F full[3] = {c.rgb[0], c.rgb[1], c.rgb[2]};
      Shader<V, kShade>{sampler_}.shade(gradient_, share, full);
      for (int i = 0; i < 3; ++i) sum[i] = V::add(sum[i], V::mask(open, full[i]));
      place = V::add(place, one);
      open = V::both(open, V::less(place, wanted));
    } while (V::any(open));
    for (int i = 0; i < 3; ++i) c.rgb[i] = V::select(shaded, V::mul(sum[i], per), c.rgb[i]);
  }

  /// Of a cell; needed are the lanes where it matters.
  F importance_of(const Part& part, const Classified& c, [[maybe_unused]] M needed) const {
    if constexpr (!kPre) return c.importance;
    const F gradient = V::set(0.0F);
    const F i_a = table_.importance_at(part.v_a, gradient);
    const F i_b = table_.importance_at(part.v_b, gradient);
    const M varies = apart(i_a, i_b);
    F whole = mean(i_a, i_b);
    if (V::any(V::both(needed, varies))) {
      whole = V::select(varies, steps<false>(part, gradient).importance, whole);
    }
    if constexpr (kFade) {
      if (fades_) whole = V::select(fade_.varies, c.importance, whole);
    }
    return whole;
  }

  const MarchInputs& in_;
  RayPacket& rays_;
  int lane_;
  MarchCounts& counts_;
  Sampler<V> sampler_;
  Table<V, kWindows> table_;
  Integrals<V> integrals_;
  Fading<V> fading_;
  F begin_;
  F end_;
  F rgb_[3];
  F alpha_;
  F cells_ = V::set(1.0F);        ///< Of the segment: 1 without kAdaptive.
  F front_{};                     ///< HU at the begin of the cell.
  F before_{};                    ///< HU at the begin of the segment before.
  F before_at_{};                 ///< Where that is; only with kAdaptive.
  typename V::Integral ends_[2];  ///< Integrals at the ends of the cell.
  int front_end_ = 0;
  bool front_classified_ = false;  ///< ends_[front_end_] is that of front_.
  F gradient_[3]{};
  Fade fade_{};               ///< Of the part at hand; only with kFade.
  bool fades_ = false;        ///< Some lane lies in front of T2.
  F front_visible_{};         ///< Visibility at the begin of the cell; only with kFade.
  bool front_faded_ = false;  ///< front_visible_ is that.
};

template <class V, MarchClassify kClassify, MarchShade kShade, bool kFade, bool kAdaptive>
void march_with(const MarchInputs& in, RayPacket& rays, MarchCounts& counts) {
  for (int lane = 0; lane < kPacketLanes; lane += V::kLanes) {
    Marcher<V, kClassify, kShade, kFade, kAdaptive>(in, rays, lane, counts).march();
  }
}

template <class V, MarchClassify kClassify, MarchShade kShade>
March composite_fading(const MarchKey& key) {
  if constexpr (kClassify == MarchClassify::kPreIntegrated) {
    if (key.adaptive) {
      return key.fade ? march_with<V, kClassify, kShade, true, true>
                      : march_with<V, kClassify, kShade, false, true>;
    }
  }
  return key.fade ? march_with<V, kClassify, kShade, true, false>
                  : march_with<V, kClassify, kShade, false, false>;
}

template <class V, MarchClassify kClassify>
March composite_shading(const MarchKey& key) {
  switch (key.shade) {
    case MarchShade::kNone:
      return composite_fading<V, kClassify, MarchShade::kNone>(key);
    case MarchShade::kPhong:
      return composite_fading<V, kClassify, MarchShade::kPhong>(key);
    case MarchShade::kGooch:
      return composite_fading<V, kClassify, MarchShade::kGooch>(key);
  }
  return nullptr;
}

/// The instance for a key.
template <class V>
March composite_march(const MarchKey& key) {
  switch (key.classify) {
    case MarchClassify::kPreIntegrated:
      return composite_shading<V, MarchClassify::kPreIntegrated>(key);
    case MarchClassify::kPostClassified:
      return composite_shading<V, MarchClassify::kPostClassified>(key);
    case MarchClassify::kWindows:
      return composite_shading<V, MarchClassify::kWindows>(key);
  }
  return nullptr;
}

}  // namespace nav::render
