// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "render/cpu/cpu_kernel_leap.hpp"
#include "render/cpu/cpu_kernel_part.hpp"
#include "render/cpu/cpu_kernel_shades.hpp"
#include "render/cpu/cpu_kernel_steps.hpp"

/// The march of ray_spec.hpp in single precision, written once for any number of lanes. V supplies
/// the arithmetic: V::F (floats), V::I (32-bit integers), V::M (lane mask), V::Integral, each with
/// V::kLanes lanes. Include this only from files that define V in an unnamed namespace. Then every
/// instance has internal linkage and stays in the file whose instruction set it was compiled for.
namespace nav::render {

/// One variant of the march. Its code contains only what the variant needs. The result of a lane
/// never depends on other lanes, so that skipping stays bit-identical.
template <class V, MarchClassify kClassify, MarchShade kShade, bool kFade, MarchCells kCells>
class Marcher {
  using F = typename V::F;
  using I = typename V::I;
  using M = typename V::M;
  using Part = CellPart<V>;
  using Classified = CellColour<V>;
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
        shades_{inputs, sampler_, counts},
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
    const bool skipping = in_.brick_leap != nullptr;
    M fresh = active;  // Lanes whose value at the begin of the cell is unknown.
    // Lanes enter bricks at different times. A brick test for each of them would cost more than
    // marching a little through empty space, which changes nothing. The more tests find nothing to
    // skip, the fewer are made.
    int patience = 1;
    for (int until_test = 0; true;) {
      if (skipping && until_test == 0) {
        if (leaper.leap(cell, end_, active, fresh)) {
          active = V::both(active, V::less(cell, end_));
          if (!V::any(active)) break;
          patience = 1;
        } else {
          patience = std::min(patience + 1, kMarchPatience);
        }
        until_test = patience * in_.cells_per_test;
      }
      int run = 1;
      if constexpr (kPre) {
        run = skipping && until_test < kMarchRun ? until_test : kMarchRun;
        add_run(cell, run, active, fresh);
      } else {
        add_cell(cell, active);
      }
      until_test -= run;
      fresh = V::none();
      cell = V::add(cell, cells(run));
      active = V::both(active, V::both(V::less(cell, end_), V::less(alpha_, opaque)));
      if (!V::any(active)) break;
    }
    V::store(rays_.alpha + lane_, alpha_);
    for (int c = 0; c < 3; ++c) V::store(rays_.rgb[c] + lane_, rgb_[c]);
  }

 private:
  /// Length of a run, in cells.
  static F cells(int run) { return V::set(static_cast<float>(run)); }

  void add_cell(F cell, M active) {
    Part part;
    part.cell = cell;
    part.t_a = V::max(cell, begin_);
    part.t_b = V::min(V::add(cell, V::set(1.0F)), end_);
    part.bow = V::set(0.0F);
    part.active = active;
    if constexpr (kCells == MarchCells::kVisible) {
      part.active = V::both(active, sampler_.visible(sampler_.locate(cell)));
      counts_.passed += static_cast<std::uint64_t>(V::count(active) - V::count(part.active));
      active = part.active;
      if (!V::any(active)) return;
    }
    counts_.samples += static_cast<std::uint64_t>(V::count(active));
    part.v_a = part.v_b = sampler_.value(cell);
    if (!may_show(part)) return;
    F gradient = V::set(0.0F);
    if constexpr (kWindows) {
      counts_.window_gradients += static_cast<std::uint64_t>(V::count(active));
      sampler_.gradient(cell, active, gradient_);
      gradient = Sampler<V>::length(gradient_);
    }
    if (!find_fade(part, gradient, false)) return;
    const auto s = table_.at(part.v_a, gradient, needs_importance());
    part.colour = {{s.rgb[0], s.rgb[1], s.rgb[2]}, s.tau, s.importance};
    finish(part, gradient);
    weigh(part);
    if constexpr (kShade != MarchShade::kNone) shade_post_classified(part);
    blend(part);
  }

  /// Adds `run` cells of each lane, one after the other. Slow memory accesses for all of them start
  /// before the first is blended, so some are in vain for rays that end in the run.
  void add_run(F cell, int run, M active, M fresh) {
    Part parts[kMarchRun];
    if constexpr (kCells == MarchCells::kVisible) {
      if (!take_visible_values(cell, run, active, fresh, parts)) return;
    } else {
      take_values(cell, run, active, fresh, parts);
    }
    for (int i = 0; i < run; ++i) find_sums(parts[i]);
    for (int i = 0; i < run; ++i) {
      if (!parts[i].shows) continue;
      integrals_.mean(parts[i].sums, parts[i].colour.rgb, parts[i].colour.tau);
      finish(parts[i], V::set(0.0F));
    }
    for (int i = 0; i < run; ++i) {
      if (!parts[i].shows) continue;
      parts[i].active = V::both(parts[i].active, V::less(alpha_, V::set(in_.opaque_at)));
      weigh(parts[i]);
      if constexpr (kShade == MarchShade::kNone) blend(parts[i]);
    }
    if constexpr (kShade != MarchShade::kNone) {
      shades_.shade(parts, run);
      for (int i = 0; i < run; ++i) {
        if (parts[i].shows) blend(parts[i]);
      }
    }
  }

  /// Sets the parts of a run.
  void take_values(F cell, int run, M active, M fresh, Part* parts) {
    if (V::any(fresh)) {
      // The other lanes get the same value as before.
      front_ = sampler_.value(cell);
      front_classified_ = front_faded_ = false;
      counts_.samples += static_cast<std::uint64_t>(V::count(V::both(fresh, active)));
    }
    if (in_.prefetch != MarchPrefetch::kNone) prefetch_run(V::add(cell, cells(run)));
    F value[kMarchRun + 1];
    value[0] = front_;
    for (int i = 1; i <= run; ++i) value[i] = sampler_.value(V::add(cell, cells(i)));
    for (int i = 0; i < run; ++i) {
      Part& part = parts[i];
      part.cell = i > 0 ? V::add(cell, cells(i)) : cell;
      part.active = i > 0 ? V::both(active, V::less(part.cell, end_)) : active;
      part.shows = true;
      counts_.samples += static_cast<std::uint64_t>(V::count(part.active));
      set_values(part, V::add(cell, cells(i + 1)), value[i], value[i + 1], fresh);
      fresh = V::none();
    }
    front_ = value[run];
  }

  /// Sets only the parts that, in any lane, have an end in a visible cell. Nothing is visible
  /// between two other ends, because their cells share a voxel. False when there is no such part.
  bool take_visible_values(F cell, int run, M active, M fresh, Part* parts) {
    typename Sampler<V>::Place ends[kMarchRun];
    if (V::any(fresh)) {
      front_known_ = front_classified_ = front_faded_ = false;
      front_seen_ = sampler_.visible(sampler_.locate(cell));
      counted_ = V::both(counted_, V::negate(fresh));
    }
    bool any = false;
    for (int i = 0; i < run; ++i) {
      Part& part = parts[i];
      ends[i] = sampler_.locate(V::add(cell, cells(i + 1)));
      const M seen = sampler_.visible(ends[i]);
      part.cell = i > 0 ? V::add(cell, cells(i)) : cell;
      const M open = i > 0 ? V::both(active, V::less(part.cell, end_)) : active;
      part.active = V::both(open, V::either(front_seen_, seen));
      part.shows = V::any(part.active);
      any = any || part.shows;
      front_seen_ = seen;
      counts_.passed += static_cast<std::uint64_t>(V::count(open) - V::count(part.active));
    }
    if (!any) {
      front_known_ = before_known_ = front_classified_ = front_faded_ = false;
      counted_ = V::none();
      return false;
    }
    F value[kMarchRun + 1];
    for (int i = 0; i < run; ++i) {
      if (parts[i].shows) {
        value[i] = front_known_
                       ? front_
                       : sampler_.value(i > 0 ? ends[i - 1] : sampler_.locate(parts[0].cell));
        front_ = value[i + 1] = sampler_.value(ends[i]);
        const M begins = V::both(parts[i].active, V::negate(counted_));
        counts_.samples += static_cast<std::uint64_t>(V::count(parts[i].active) + V::count(begins));
        counted_ = parts[i].active;
      } else {
        counted_ = V::none();
      }
      front_known_ = parts[i].shows;
    }
    // Lanes in which before_ is not the value in front of the part.
    M lacking = before_known_ ? fresh : V::all();
    for (int i = 0; i < run; ++i) {
      if (parts[i].shows) {
        set_values(parts[i], V::add(cell, cells(i + 1)), value[i], value[i + 1], lacking);
      }
      lacking = parts[i].shows ? V::none() : V::all();
    }
    before_known_ = parts[run - 1].shows;
    return true;
  }

  /// Prefetches the voxels of the run that begins at \p cell if nothing is skipped.
  __attribute__((always_inline)) void prefetch_run(F cell) const {
    const bool all = in_.prefetch == MarchPrefetch::kAll;
    const int every = all ? 1 : 2;
    for (int i = every; i <= kMarchRun; i += every) {
      const auto place = sampler_.locate(V::add(cell, V::set(static_cast<float>(i))));
      if (all) {
        sampler_.prefetch_cells(in_.voxels, in_.slice_stride, place.base);
      } else {
        sampler_.prefetch_corners(in_.voxels, in_.slice_stride, place.base);
      }
    }
  }

  /// Sets the part of a cell up to next from the values at the two lattice points.
  void set_values(Part& part, F next, F v0, F v1, M fresh) {
    part.t_a = V::max(part.cell, begin_);
    part.t_b = V::min(next, end_);
    const M cut_a = V::less(part.cell, part.t_a);
    const M cut_b = V::less(part.t_b, next);
    const F rise = V::sub(v1, v0);
    const M cut = V::either(cut_a, cut_b);
    part.v_a = v0;
    part.v_b = v1;
    if (V::any(cut)) {
      part.v_a = V::select(cut_a, V::madd(V::sub(part.t_a, part.cell), rise, v0), v0);
      part.v_b = V::select(cut_b, V::madd(V::sub(part.t_b, part.cell), rise, v0), v1);
      // Only the first cell of a run can be cut at its front.
      if (V::any(V::both(part.active, cut_a))) front_classified_ = front_faded_ = false;
    }
    const M bowed = V::both(V::negate(cut), V::less(V::set(1.5F), part.cell));
    // A bow has no effect if both ends are invisible.
    const M may_bow = V::both(bowed, V::less(V::set(in_.invisible_up_to_hu), V::max(v0, v1)));
    set_before(part.cell, V::both(part.active, may_bow), fresh);
    const F rise_before = V::sub(v0, before_);
    part.bow = V::mask(bowed, V::mul(V::sub(rise_before, rise), V::set(1.0F / 12)));
    before_ = v0;
  }

  /// Computes the integrals of a pre-integrated part, if it shows.
  void find_sums(Part& part) {
    part.shows = part.shows && may_show(part);
    if (!part.shows) {
      front_classified_ = front_faded_ = false;
      return;
    }
    part.shows = find_fade(part, V::set(0.0F), front_faded_);
    if (!part.shows) {
      front_classified_ = false;
      return;
    }
    if (!front_classified_) integrals_.at(part.v_a, ends_[front_end_]);
    integrals_.at(part.v_b, ends_[1 - front_end_]);
    integrals_.sum(part.v_a, part.v_b, part.bow, ends_[front_end_], ends_[1 - front_end_],
                   part.sums);
    part.colour.importance = V::set(1.0F);
    // A lane that is cut at its back ends there. In all lanes that continue, the end of this part
    // is the begin of the next.
    front_end_ = 1 - front_end_;
    front_classified_ = true;
  }

  /// Sets before_ to the value at the lattice point in front of a cell, in lanes that need it.
  void set_before(F cell, M needed, M fresh) {
    const M unknown = V::both(needed, fresh);
    if (!V::any(unknown)) return;
    before_ = V::select(unknown, sampler_.value(V::sub(cell, V::set(1.0F))), before_);
    counts_.samples += static_cast<std::uint64_t>(V::count(unknown));
  }

  [[nodiscard]] bool may_show(const Part& part) const {
    const F most = V::max(part.v_a, part.v_b);
    return V::any(V::both(part.active, V::less(V::set(in_.invisible_up_to_hu), most)));
  }

  /// Sets fade. False when the cutaway hides the part in every lane. \p goes_on: the part begins at
  /// the end of the last one.
  bool find_fade([[maybe_unused]] Part& part, [[maybe_unused]] F gradient,
                 [[maybe_unused]] bool goes_on) {
    if constexpr (kFade) {
      CellFade<V>& fade = part.fade;
      fade.before = V::both(part.active, V::less(part.t_a, fading_.t2));
      front_faded_ = fade.any = V::any(fade.before);
      if (!fade.any) return true;
      counts_.faded += static_cast<std::uint64_t>(V::count(fade.before));
      const F i_b = table_.importance_at(part.v_b, gradient);
      F visible_a = front_visible_;
      if (!goes_on) {
        const F i_a = kPre ? table_.importance_at(part.v_a, gradient) : i_b;
        visible_a = fading_.visibility(i_a, part.t_a);
      }
      const F visible_b = front_visible_ = fading_.visibility(i_b, part.t_b);
      fade.varies = V::both(fade.before, apart(visible_a, visible_b));
      fade.visible = V::select(fade.before, mean(visible_a, visible_b), V::set(1.0F));
      return V::any(V::both(part.active, V::less(V::set(0.0F), fade.visible)));
    }
    return true;
  }

  static M apart(F a, F b) { return V::less(V::set(kMarchFadeVaries), V::abs(V::sub(a, b))); }
  static F mean(F a, F b) { return V::mul(V::set(0.5F), V::add(a, b)); }

  /// Fades a part's colour and computes its opacity.
  void finish(Part& part, [[maybe_unused]] F gradient) const {
    Classified& c = part.colour;
    if constexpr (kFade) {
      if (part.fade.any) {
        c.tau = Fading<V>::faded(c.tau, part.fade.visible);
        const M varies = part.fade.varies;
        if (V::any(varies)) {
          const Classified mean = steps<true>(part, gradient, varies);
          for (int i = 0; i < 3; ++i) c.rgb[i] = V::select(varies, mean.rgb[i], c.rgb[i]);
          c.tau = V::select(varies, mean.tau, c.tau);
          c.importance = V::select(varies, mean.importance, c.importance);
        }
      }
    }
    const F length = V::sub(part.t_b, part.t_a);
    const F depth = V::mul(V::mul(c.tau, V::set(in_.step_mm)), length);
    part.opacity = V::one_minus_exp(V::max(depth, V::set(0.0F)));
  }

  [[nodiscard]] bool needs_importance() const {
    return kShade != MarchShade::kNone && in_.emphasis > 0;
  }

  /// Mean of the equidistant midpoints of a part, faded or not. Undefined in lanes that do not need
  /// it.
  template <bool kFaded>
  Classified steps(const Part& part, F gradient, [[maybe_unused]] M needed) const {
    const PartSteps<V, kWindows> steps{table_, fading_};
    if constexpr (kPre) {
      if constexpr (V::kPacks) {
        if (kMarchFadeSteps * V::count(needed) <= (kMarchFadeSteps - 1) * V::kLanes) {
          return steps.template packed<kFaded>(part, needed);
        }
      }
      return steps.template between<kFaded>(part);
    } else {
      return steps.template of<kFaded>(part, table_.at(part.v_a, gradient, true));
    }
  }

  /// Computes the weight of a part in the pixel and adds it to the opacity.
  void weigh(Part& part) {
    part.weight = V::mask(part.active, V::mul(part.opacity, V::sub(V::set(1.0F), alpha_)));
    alpha_ = V::add(alpha_, part.weight);
    if constexpr (kShade != MarchShade::kNone) find_shades(part);
  }

  void blend(const Part& part) {
    for (int i = 0; i < 3; ++i) rgb_[i] = V::madd(part.weight, part.colour.rgb[i], rgb_[i]);
  }

  void find_shades(Part& part) {
    CellShades<V>& shades = part.shades;
    shades.places = 0;
    shades.share = V::set(1.0F);
    M shaded = V::less(V::set(in_.min_shaded_weight), part.weight);
    if (!V::any(shaded)) return;
    if (in_.emphasis > 0) {
      const F unimportant = V::sub(V::set(1.0F), importance_of(part, part.colour, shaded));
      shades.share = V::sub(V::set(1.0F), V::mul(V::set(in_.emphasis), unimportant));
      shaded = V::both(shaded, V::less(V::set(0.0F), shades.share));
      if (!V::any(shaded)) return;
    }
    if constexpr (kPre) {
      shades_.find_places(part, shaded);
    } else {
      shades.places = 1;
      shades.open[0] = shaded;
    }
  }

  void shade_post_classified(Part& part) {
    const CellShades<V>& shades = part.shades;
    if (shades.places == 0) return;
    counts_.gradients += static_cast<std::uint64_t>(V::count(shades.open[0]));
    Classified& c = part.colour;
    if constexpr (!kWindows) sampler_.gradient(part.cell, shades.open[0], gradient_);
    F full[3] = {c.rgb[0], c.rgb[1], c.rgb[2]};
    Shader<V, kShade>{sampler_}.shade(gradient_, shades.share, full);
    for (int i = 0; i < 3; ++i) c.rgb[i] = V::select(shades.open[0], full[i], c.rgb[i]);
  }

  /// Importance of a cell. \p needed: the lanes in which it matters.
  F importance_of(const Part& part, const Classified& c, [[maybe_unused]] M needed) const {
    if constexpr (!kPre) return c.importance;
    const F gradient = V::set(0.0F);
    const F i_a = table_.importance_at(part.v_a, gradient);
    const F i_b = table_.importance_at(part.v_b, gradient);
    const M varies = apart(i_a, i_b);
    F whole = mean(i_a, i_b);
    if (V::any(V::both(needed, varies))) {
      whole = V::select(varies, steps<false>(part, gradient, V::both(needed, varies)).importance,
                        whole);
    }
    if constexpr (kFade) {
      if (part.fade.any) whole = V::select(part.fade.varies, c.importance, whole);
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
  RunShades<V, kShade> shades_;
  F begin_;
  F end_;
  F rgb_[3];
  F alpha_;
  F front_{};                     ///< HU at the begin of the cell.
  bool front_known_ = false;      ///< front_ is valid.
  M front_seen_{};                ///< Lanes in which the begin of the cell lies in a visible cell.
  M counted_ = V::none();         ///< Lanes in which the sample front_ is already counted.
  F before_{};                    ///< HU at the begin of the previous cell.
  bool before_known_ = false;     ///< before_ is valid, except in lanes that have leapt.
  typename V::Integral ends_[2];  ///< Integrals at the ends of the cell.
  int front_end_ = 0;
  bool front_classified_ = false;  ///< ends_[front_end_] is the integral at front_.
  F gradient_[3]{};
  F front_visible_{};         ///< Visibility at the begin of the cell; only with kFade.
  bool front_faded_ = false;  ///< front_visible_ is valid.
};

}  // namespace nav::render
