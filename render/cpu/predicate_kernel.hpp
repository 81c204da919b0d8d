// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "render/cpu/cpu_kernel_classify.hpp"
#include "render/cpu/cpu_kernel_leap.hpp"
#include "render/cpu/cpu_kernel_shade.hpp"
#include "render/cpu/predicate_march.hpp"

/// Predicates in lanes, in single precision: predicate_scene.hpp. See cpu_kernel.hpp for V and for
/// the files that may include this. Here V also has the integer logic of predicate_lanes_*.hpp.
namespace nav::render {

/// Unit of pair weights. It fits in 16 bits with a sign, so values are interpolated along y by
/// integer products, with half of the arithmetic. Equal values stay unchanged.
inline constexpr float kWhole = 16384;

/// One sample of the volume in every lane.
template <class V>
struct LaneSample {
  using F = typename V::F;
  using I = typename V::I;

  F cell;
  F volume;  ///< Code of channel 0.
  I base;    ///< Offset as in Sampler::Place. The weights along y are stored in pairs.
  F along_x;
  I along_y;
  F along_z;

  void take(const PredicateInputs& in, const Sampler<V>& sampler, F at) {
    cell = at;
    const auto place = sampler.locate(at);
    base = place.base;
    along_x = place.w[0];
    along_y = V::pair_weights(place.w[1]);
    along_z = V::mul(place.w[2], V::set(1 / kWhole));
    I words[4];
    load(in, 0, words);
    volume = interpolate(words);
  }
  void load(const PredicateInputs& in, int channel, I* words) const {
    V::load_cell_words(in.codes[channel], in.base.slice_stride, base, words);
  }
  F interpolate(const I* words) const {
    F at[4];
    for (int i = 0; i < 4; ++i) at[i] = V::weigh(words[i], along_y);
    const F near = Sampler<V>::lerp(at[0], at[1], along_x);
    const F far = Sampler<V>::lerp(at[2], at[3], along_x);
    return V::madd(along_z, V::sub(far, near), V::mul(near, V::set(1 / kWhole)));
  }
};

/// Tests of the leaves for one sample of every lane. The result of a lane never depends on other
/// lanes.
template <class V>
struct LeafTests {
  using F = typename V::F;
  using I = typename V::I;
  using M = typename V::M;

  const PredicateInputs& in;
  const Sampler<V>& sampler;
  const LaneSample<V>& sample;

  /// Code of a channel. \p defined keeps the lanes in which all eight voxels have a code.
  F code(int channel, M& defined) const {
    if (channel == 0) return sample.volume;
    I words[4];
    sample.load(in, channel, words);
    if (in.has_undefined[channel]) {
      F least = V::set(0.0F);
      for (const I word : words) {
        least = V::min(least, V::min(V::first_of(word), V::second_of(word)));
      }
      defined = V::both(defined, V::less(V::set(-32767.5F), least));
    }
    return sample.interpolate(words);
  }

  static M between(F x, float low, float high) {
    return V::both(V::not_less(x, V::set(low)), V::not_less(V::set(high), x));
  }

  F position(int axis) const {
    return V::mul(sampler.coordinate(axis, sample.cell), V::set(in.spacing_mm[axis]));
  }

  M wedge(const PredicateAtom& atom) const {
    M defined = V::not_less(sample.cell, sample.cell);
    F v[2];
    for (int i = 0; i < 2; ++i) {
      v[i] = V::madd(code(atom.channel[i], defined), V::set(atom.scale[i]), V::set(atom.offset[i]));
    }
    const F square = V::madd(v[0], v[0], V::mul(v[1], v[1]));
    M out = V::both(defined, V::not_less(square, V::set(atom.low)));
    for (int i = 0; i < 3; ++i) {
      const auto& form = atom.wedge[i];
      const F side = V::madd(v[0], V::set(form[0]), V::mul(v[1], V::set(form[1])));
      out = V::both(out, V::not_less(side, V::set(-atom.slack[i])));
    }
    return out;
  }

  M segment(const PredicateAtom& atom) const {
    F d[3];
    F foot = V::set(0.0F);
    for (int i = 0; i < 3; ++i) {
      d[i] = V::sub(position(i), V::set(atom.a[i]));
      foot = V::madd(d[i], V::set(atom.foot[i]), foot);
    }
    foot = V::max(V::set(0.0F), V::min(V::set(1.0F), foot));
    F square = V::set(0.0F);
    for (int i = 0; i < 3; ++i) {
      const F off = V::sub(d[i], V::mul(foot, V::set(atom.axis[i])));
      square = V::madd(off, off, square);
    }
    return between(square, atom.low, atom.high);
  }

  M slab(const PredicateAtom& atom) const {
    F depth = V::set(0.0F);
    for (int i = 0; i < 3; ++i) depth = V::madd(position(i), V::set(atom.a[i]), depth);
    return between(depth, atom.low, atom.high);
  }

  M bits(const PredicateAtom& atom) const {
    I index[3];
    for (int axis = 0; axis < 3; ++axis) {
      index[axis] = V::truncate(V::add(sampler.coordinate(axis, sample.cell), V::set(0.5F)));
    }
    const I at = V::add(V::add(V::mul(index[2], V::set_int(in.label_slice)),
                               V::mul(index[1], V::set_int(in.label_row))),
                        index[0]);
    return V::has_bits(V::load_int(reinterpret_cast<const std::int32_t*>(in.labels), at),
                       V::set_int(atom.mask));
  }

  M range(const PredicateAtom& atom) const {
    M defined = V::not_less(sample.cell, sample.cell);
    const F value = code(atom.channel[0], defined);
    return V::both(defined, between(value, atom.low, atom.high));
  }

  /// Tests all atoms except ranges of the volume itself. Not inlined, because bricks have decided
  /// most of them.
  __attribute__((noinline)) M test_other(const PredicateAtom& atom) const {
    switch (atom.kind) {
      case PredicateAtom::kRange:
        return range(atom);
      case PredicateAtom::kWedge:
        return wedge(atom);
      case PredicateAtom::kBits:
        return bits(atom);
      case PredicateAtom::kSegment:
        return segment(atom);
      case PredicateAtom::kSlab:
        return slab(atom);
      default:
        return V::none();
    }
  }

  M test(const PredicateAtom& atom) const {
    const bool of_volume = atom.kind == PredicateAtom::kRange && atom.channel[0] == 0;
    return of_volume ? between(sample.volume, atom.low, atom.high) : test_other(atom);
  }
};

/// The march of predicate_scene.hpp.
template <class V, PredicateBlend kBlend, bool kFade, bool kShade>
class PredicateMarcher {
  using F = typename V::F;
  using I = typename V::I;
  using M = typename V::M;

  static constexpr float kAhead = 8;  ///< Number of cells for which bricks are looked up at once.
  static constexpr float kAskEvery = 4;  ///< Number of cells between two lookups of rule 1; a power
                                         ///< of two.
  static constexpr int kMostBricks = 12;  ///< Greatest number of bricks that is worth looking up.
  static constexpr float kSomething = 1e-30F;  ///< spec::LeftOut::any: then spent is at least this.

 public:
  PredicateMarcher(const PredicateInputs& inputs, RayPacket& rays, PredicateRays& more, int lane,
                   MarchCounts& counts)
      : in_(inputs),
        rays_(rays),
        more_(more),
        lane_(lane),
        counts_(counts),
        sampler_(inputs.base, rays, lane),
        bricks_(sampler_),
        fading_(inputs.base, rays, lane),
        begin_(V::load(rays.begin + lane)),
        end_(V::load(rays.end + lane)),
        alpha_(V::load(rays.alpha + lane)),
        image_(V::load(more.image + lane)),
        importance_(V::load(more.importance + lane)),
        left_out_(V::load(more.left_out + lane)) {
    for (int c = 0; c < 3; ++c) rgb_[c] = V::load(rays.rgb[c] + lane);
  }

  void march() {
    F cell = V::floor(begin_);
    M active = V::less(begin_, end_);
    if constexpr (kBlend == PredicateBlend::kOver) {
      active = V::both(active, V::less(alpha_, V::set(in_.end_at)));
    }
    if (!V::any(active)) return;
    Leaper<V, false, false> leaper(sampler_, rays_, lane_, cell);
    M moved = V::none();
    until_ = V::set(-1e30F);
    const bool skipping = in_.base.brick_leap != nullptr;
    // Marching on until the next brick test changes nothing: see Marcher::march().
    int patience = 1;
    for (int until_test = 0; V::any(active);) {
      if (skipping && until_test == 0) {
        const bool leapt = leaper.leap(cell, end_, active, moved);
        patience = leapt ? 1 : std::min(patience + 1, kMarchPatience);
        active = V::both(active, V::less(cell, end_));
        if (!V::any(active)) break;
        until_test = patience * in_.base.cells_per_test;
      }
      const int run = skipping && until_test < kMarchRun ? until_test : kMarchRun;
      cell = add_run(cell, run, active);
      until_test -= run;
      active = V::both(active, V::less(cell, end_));
    }
    V::store(rays_.alpha + lane_, alpha_);
    V::store(more_.image + lane_, image_);
    V::store(more_.importance + lane_, importance_);
    V::store(more_.left_out + lane_, left_out_);
    for (int c = 0; c < 3; ++c) V::store(rays_.rgb[c] + lane_, rgb_[c]);
  }

 private:
  /// Appearance of a sample of every lane.
  struct Part {
    LaneSample<V> sample;
    F x;       ///< Intensity.
    M shown;   ///< Lanes in which it may be visible.
    I leaves;  ///< Leaves that are true there.
    F appearance[4];
    F opacity;  ///< 0 in lanes in which it is not visible.
  };

  /// Rule 1 of spec::EarlyEnds, brick by brick. Lanes test together, every kAskEvery cells. Behind
  /// a brick that was left out, the next one is tested at once, unless the brick showed nothing:
  /// leaps and marching also reach the end of such bricks.
  F leave_out(F cell, M active) {
    M open = V::both(active, V::not_less(alpha_, V::set(in_.leave_out_from)));
    if (!V::any(open)) return cell;
    open = V::both(open, asks(cell));
    while (V::any(open)) {
      const auto brick = bricks_.find(cell);
      const F most = V::load_float(in_.brick_importance, brick.at);
      const F leave = bricks_.leave(brick, cell);
      const F paid = V::max(importance_, paid_);
      const F rise = V::max(V::set(0.0F), V::sub(most, paid));
      const F spent = V::add(spent_so_far(), cost_of(rise));
      const M shows = V::less(V::set(0.0F), most);
      const M affordable = V::not_less(V::set(in_.leave_out_for), spent);
      const M free = V::both(open, V::either(affordable, V::negate(shows)));
      const M visible = V::both(free, shows);
      left_out_ = V::select(visible, V::max(spent, V::set(kSomething)), left_out_);
      paid_ = V::select(visible, V::max(paid, most), paid_);
      cell = V::select(free, leave, cell);
      open = V::both(V::both(free, V::either(shows, asks(cell))), V::less(cell, end_));
    }
    return cell;
  }

  static M asks(F cell) {
    const F share = V::mul(cell, V::set(1.0F / kAskEvery));
    return V::not_less(V::floor(share), share);
  }

  /// spec::LeftOut::pay(): the amount spent before the next omitted sample.
  F spent_so_far() const {
    const F missing = V::sub(V::set(1.0F), alpha_);
    return V::select(V::less(left_out_, V::set(kSomething)), V::add(missing, missing), left_out_);
  }

  /// spec::LeftOut::pay(): the cost of more importance than was paid for.
  F cost_of(F more) const {
    if constexpr (kBlend == PredicateBlend::kWeight) {
      return V::div(more, V::max(importance_, V::set(1e-37F)));
    }
    // At least the value of the formula. Its exponents are at most ln(1 + y), where y is the
    // greatest payment.
    const float most = in_.leave_out_for;
    return V::mul(more, V::set((1 + most) * (1 + 0.5F * most)));
  }

  /// Rule 2: lanes whose light is final. It does not apply to rays for which rule 1 has begun. The
  /// rest of all rays on their way is searched together, because separate searches would take as
  /// many steps.
  M finished(F cell, M lanes, M on_their_way) {
    M dense = V::both(lanes, V::not_less(alpha_, V::set(in_.end_at)));
    if (!V::any(dense)) return V::none();
    if constexpr (kBlend == PredicateBlend::kOver) return dense;
    dense = V::both(dense, V::less(left_out_, V::set(kSomething)));
    const M stale = V::not_less(ahead(cell, 1), greatest_until_);
    if (V::any(V::both(dense, stale))) look_ahead(cell, V::both(on_their_way, stale));
    if constexpr (kBlend == PredicateBlend::kLog) {
      const F more = V::max(V::set(0.0F), V::sub(greatest_, importance_));
      const F kept = V::sub(V::set(1.0F), V::one_minus_exp(more));
      return V::both(dense, V::not_less(V::mul(alpha_, kept), V::set(in_.end_at)));
    }
    const F kept = V::mul(alpha_, V::min(importance_, greatest_));
    return V::both(dense, V::not_less(kept, V::mul(greatest_, V::set(in_.end_at))));
  }

  /// Finds the greatest importance on the rest of the rays of some lanes, and the cell in front of
  /// which it lies for the last time.
  void look_ahead(F cell, M lanes) {
    greatest_ = V::select(lanes, V::set(0.0F), greatest_);
    greatest_until_ = V::select(lanes, end_, greatest_until_);
    F at = V::add(cell, V::set(1.0F));
    M open = V::both(lanes, V::less(at, end_));
    while (V::any(open)) {
      const auto brick = bricks_.find(at);
      const F most = V::load_float(in_.brick_importance, brick.at);
      const F leave = bricks_.leave(brick, at);
      const M more = V::both(open, V::not_less(most, greatest_));
      greatest_ = V::select(more, most, greatest_);
      greatest_until_ = V::select(more, leave, greatest_until_);
      at = V::select(open, leave, at);
      open = V::both(open, V::less(at, end_));
    }
  }

  /// Finds the leaves that are true at each sample of a run that may be visible. Tests one leaf
  /// after the other, so that the features of all samples are requested at once.
  void find_leaves(F cell, int run, M active, Part* parts) {
    if (V::any(V::both(active, V::not_less(ahead(cell, run - 1), until_)))) {
      look_around(cell, active);
    }
    for (int i = 0; i < run; ++i) parts[i].leaves = V::set_int(static_cast<int>(sure_));
    std::uint32_t known = in_.all_leaves & ~ask_;
    for (int n = 0; n < in_.leaf_count; ++n) {
      const int leaf = in_.order[n];
      const std::uint32_t bit = 1U << leaf;
      if ((ask_ & bit) == 0) continue;
      for (int i = 0; i < run; ++i) {
        Part& part = parts[i];
        if (n >= in_.cheap_leaves && !matters(leaf, known, part.leaves, part.shown)) continue;
        const LeafTests<V> tests{in_, sampler_, part.sample};
        const M is = V::both(part.shown, tests.test(in_.atoms[leaf]));
        part.leaves = V::or_where(is, V::set_int(static_cast<int>(bit)), part.leaves);
      }
      known |= bit;  // Set even if the leaf was not tested: either value gives the same appearance.
    }
  }

  /// True when a leaf may decide the appearance of a lane.
  [[nodiscard]] bool matters(int leaf, std::uint32_t known, I bits, M shown) const {
    if (in_.matters == nullptr) return V::any(shown);
    const std::uint64_t where = in_.matters[static_cast<std::uint32_t>(in_.leaf_count) * known +
                                            static_cast<std::uint32_t>(leaf)];
    return V::any_among(bits, shown, where);
  }

  /// Finds the leaves that are decided in all bricks that active lanes cross in their next cells.
  void look_around(F cell, M active) {
    until_ = V::select(active, V::add(cell, V::set(kAhead)), until_);
    sure_ = 0;
    ask_ = in_.all_leaves;
    if (in_.brick_open == nullptr) return;
    int low[3];
    int high[3];
    int count = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const F from = sampler_.coordinate(axis, cell);
      const F to = sampler_.coordinate(axis, V::add(cell, V::set(kAhead - 1)));
      const F least = V::select(active, V::min(from, to), V::set(1e9F));
      const F most = V::select(active, V::max(from, to), V::set(0.0F));
      low[axis] = static_cast<int>(V::least_of(least)) >> 3;
      high[axis] = static_cast<int>(V::greatest_of(most)) >> 3;
      count *= high[axis] - low[axis] + 1;
    }
    if (count <= kMostBricks) agree(low, high);
  }

  void agree(const int* low, const int* high) {
    std::uint32_t all = ~0U;
    std::uint32_t any = 0;
    std::uint32_t open = 0;
    for (int z = low[2]; z <= high[2]; ++z) {
      for (int y = low[1]; y <= high[1]; ++y) {
        for (int x = low[0]; x <= high[0]; ++x) {
          const int at = (z * in_.base.bricks[1] + y) * in_.base.bricks[0] + x;
          const auto sure = static_cast<std::uint32_t>(in_.brick_sure[at]);
          all &= sure;
          any |= sure;
          open |= static_cast<std::uint32_t>(in_.brick_open[at]);
        }
      }
    }
    sure_ = all;
    ask_ = (open | any) & ~all;
  }

  F fade(F tau, F importance, F t_a, F t_b) const {
    F count = importance;
    if constexpr (kBlend == PredicateBlend::kWeight) {
      count = V::add(V::log(V::max(importance, V::set(1e-37F))), V::set(in_.cutaway_greatest));
    }
    F share = V::max(V::set(0.0F), V::mul(count, V::set(in_.cutaway_scale)));
    share = V::select(V::not_less(share, V::set(kMarchFullImportance)), V::set(1.0F), share);
    F sum = V::set(0.0F);
    for (int j = 0; j < kMarchFadeSteps; ++j) {
      const F w = V::set((static_cast<float>(j) + 0.5F) / kMarchFadeSteps);
      sum = V::add(sum, fading_.visibility(share, Sampler<V>::lerp(t_a, t_b, w)));
    }
    const F mean = V::mul(sum, V::set(1.0F / kMarchFadeSteps));
    return V::select(V::less(t_a, fading_.t2), Fading<V>::faded(tau, mean), tau);
  }

  /// Adds `run` cells of each lane, one after the other. Returns the next cells, without those that
  /// rule 1 leaves out, and removes finished lanes from active. Everything that does not depend on
  /// the accumulated light is computed for all cells before the first is blended, so that no cell
  /// waits for the previous one. Samples that are left out later were taken in vain.
  F add_run(F cell, int run, M& active) {
    Part parts[kMarchRun];
    if (in_.base.prefetch != MarchPrefetch::kNone) prefetch_run(ahead(cell, run));
    for (int i = 0; i < run; ++i) sample(ahead(cell, i), active, parts[i]);
    find_leaves(cell, run, active, parts);
    for (int i = 0; i < run; ++i) classify(parts[i]);
    F next = cell;
    for (int i = 0; i < run; ++i) {
      const F at = ahead(cell, i);
      M here = V::both(active, V::both(V::not_less(at, next), V::less(at, end_)));
      if constexpr (kBlend != PredicateBlend::kOver) {
        next = V::select(here, leave_out(at, here), next);
        here = V::both(here, V::not_less(at, next));
      }
      const M shown = V::both(here, parts[i].shown);
      if (!V::any(shown)) continue;
      blend(parts[i], V::mask(shown, parts[i].opacity));
      active = V::both(active, V::negate(finished(at, shown, active)));
    }
    return V::max(next, ahead(cell, run));
  }

  /// Prefetches the run that begins at \p cell if nothing is skipped, at the corners of the packet:
  /// the volume and the features that were last requested.
  __attribute__((always_inline)) void prefetch_run(F cell) const {
    const int slice = in_.base.slice_stride;
    for (int i = 1; i < kMarchRun; i += 2) {
      const I base = sampler_.locate(ahead(cell, i)).base;
      sampler_.prefetch_corners(in_.codes[0], slice, base);
      for (int n = in_.cheap_leaves; n < in_.leaf_count; ++n) {
        if ((ask_ >> in_.order[n] & 1U) == 0) continue;
        const PredicateAtom& atom = in_.atoms[in_.order[n]];
        for (int c = 0; c < channels_of(atom.kind); ++c) {
          sampler_.prefetch_corners(in_.codes[atom.channel[c]], slice, base);
        }
      }
    }
  }

  static F ahead(F cell, int cells) { return V::add(cell, V::set(static_cast<float>(cells))); }

  void sample(F cell, M active, Part& part) {
    part.sample.take(in_, sampler_, cell);
    active = V::both(active, V::less(cell, end_));
    counts_.samples += static_cast<std::uint64_t>(V::count(active));
    const F x =
        V::madd(part.sample.volume, V::set(in_.intensity_scale), V::set(in_.intensity_offset));
    const F zero = V::set(0.0F);
    part.shown = V::both(active, V::less(zero, x));
    part.x = V::min(V::max(x, zero), V::set(1.0F));
  }

  void classify(Part& part) {
    if (!V::any(part.shown)) return;
    find_appearances(part.leaves, part.shown, part.appearance);
    part.shown = V::both(part.shown, V::less(V::set(0.0F), part.appearance[3]));
    if (!V::any(part.shown)) return;
    const F cell = part.sample.cell;
    const F t_a = V::max(cell, begin_);
    const F t_b = V::min(ahead(cell, 1), end_);
    part.opacity = opacity_of(part.x, part.appearance[3], t_a, t_b, part.shown);
  }

  /// Opacity of the part from t_a to t_b of a cell; 0 in lanes that show nothing.
  F opacity_of(F x, F importance, F t_a, F t_b, M shown) {
    const F length = V::sub(t_b, t_a);
    const M whole = V::not_less(length, V::set(1.0F));
    M faded = V::none();
    if constexpr (kFade) {
      faded = V::both(shown, V::less(t_a, fading_.t2));
      counts_.faded += static_cast<std::uint64_t>(V::count(faded));
    }
    const M nearly_white =
        V::both(V::less(V::set(OpacityPieces::kWhitest), x), V::less(x, V::set(1.0F)));
    const M special = V::either(V::either(faded, nearly_white), V::negate(whole));
    const bool by_pieces = in_.opacity != nullptr;
    if (by_pieces && !V::any(V::both(shown, special))) return V::mask(shown, whole_opacity(x));
    F tau = tau_of(x);
    if constexpr (kFade) tau = fade(tau, importance, t_a, t_b);
    const F depth = V::mul(V::mul(tau, V::set(in_.base.step_mm)), length);
    const F exact = V::one_minus_exp(V::max(depth, V::set(0.0F)));
    return V::mask(shown, by_pieces ? V::select(special, exact, whole_opacity(x)) : exact);
  }

  /// OpacityPieces at x; undefined between kWhitest and white.
  F whole_opacity(F x) const {
    I piece;
    F t;
    const F z = V::sub(V::set(OpacityPieces::kMost), x);
    V::octave(z, piece, t);
    const auto factor = [&](int i) {
      return V::pick(in_.opacity + i * OpacityPieces::kPieces, 1, piece);
    };
    F sum = factor(OpacityPieces::kFactors - 1);
    for (int i = OpacityPieces::kFactors - 2; i >= 0; --i) sum = V::madd(sum, t, factor(i));
    return V::select(V::less(x, V::set(1.0F)), sum, V::set(in_.white_opacity));
  }

  /// Extinction of an intensity, per mm.
  F tau_of(F x) const {
    const F at = V::mul(x, V::set(in_.last_entry));
    const F floor = V::floor(V::min(at, V::set(in_.last_entry - 1)));
    F value;
    F rise;
    V::load_float_pair(in_.tau, V::truncate(V::add(floor, floor)), value, rise);
    return V::madd(V::sub(at, floor), rise, value);
  }

  /// Finds the appearance of the lanes in \p asked.
  void find_appearances(I leaves, M asked, F* appearance) const {
    const bool reads_numbers = in_.appearance_numbers != nullptr;
    if (in_.appearance_nibbles != nullptr && (reads_numbers || in_.few_eights > V::kEightsAtOnce)) {
      const I at = V::nibble(in_.appearance_nibbles, leaves);
      pick_appearances(in_.numbered_appearances, in_.numbered_eights, at, appearance);
      return;
    }
    if (in_.few_appearances != nullptr) {
      const I at = reads_numbers ? V::load_int(in_.appearance_numbers, leaves) : leaves;
      pick_appearances(in_.few_appearances, in_.few_eights, at, appearance);
      return;
    }
    std::uint32_t bits[V::kLanes];
    if (V::same(leaves, asked, bits[0])) {
      PredicateAppearance found;
      const PredicateAppearance* one = appearance_of(bits[0], found);
      for (int c = 0; c < 3; ++c) appearance[c] = V::set(one->tint[c]);
      appearance[3] = V::set(one->importance);
      return;
    }
    const PredicateAppearance* entries[V::kLanes];
    PredicateAppearance found[V::kLanes];
    V::store_int(reinterpret_cast<std::int32_t*>(bits), leaves);
    for (int lane = 0; lane < V::kLanes; ++lane) {
      const bool again = lane > 0 && bits[lane] == bits[lane - 1];
      entries[lane] = again ? entries[lane - 1] : appearance_of(bits[lane], found[lane]);
    }
    V::load_appearances(entries, appearance);
  }

  static void pick_appearances(const float* columns, int eights, I at, F* appearance) {
    for (int c = 0; c < 4; ++c) appearance[c] = V::pick(columns + 8 * c * eights, eights, at);
  }

  const PredicateAppearance* appearance_of(std::uint32_t leaves, PredicateAppearance& found) const {
    if (in_.appearances != nullptr) return in_.appearances + leaves;
    in_.find_appearance(in_.appearance_finder, leaves, &found);
    return &found;
  }

  /// PredicateShading of the colours of samples.
  void shade(F cell, M shown, F* colour) {
    F gradient[3];
    sampler_.gradient(cell, shown, gradient);
    counts_.gradients += static_cast<std::uint64_t>(V::count(shown));
    F full[3] = {colour[0], colour[1], colour[2]};
    Shader<V, MarchShade::kPhong>{sampler_}.shade(gradient, V::set(1.0F), full);
    for (int c = 0; c < 3; ++c) colour[c] = V::select(shown, full[c], colour[c]);
  }

  /// spec::composite_over(), composite_weight() or composite_log(); opacity 0 changes nothing.
  void blend(const Part& part, F opacity) {
    const F one = V::set(1.0F);
    const F zero = V::set(0.0F);
    const F x = part.x;
    const F importance = part.appearance[3];
    const M counts = V::less(zero, opacity);
    F a = alpha_;
    F next = importance_;
    if constexpr (kBlend == PredicateBlend::kWeight) {
      const F least = V::div(importance_, V::max(importance, V::set(1e-37F)));
      a = V::select(V::not_less(importance_, importance), alpha_, V::min(alpha_, least));
      next = V::max(importance_, V::madd(opacity, V::sub(importance, importance_), importance_));
    } else if constexpr (kBlend == PredicateBlend::kLog) {
      const F more = V::max(zero, V::sub(importance, importance_));
      const F lost = V::one_minus_exp(more);
      a = V::min(alpha_, V::sub(one, lost));
      const F gained = V::log1p(V::sub(zero, V::mul(V::sub(one, opacity), lost)));
      next = V::select(V::less(importance_, importance),
                       V::max(importance_, V::add(importance, gained)), importance_);
    }
    const F over = V::mul(V::sub(one, a), opacity);
    const F beta = V::mask(counts, V::div(over, V::max(V::add(a, over), V::set(1e-37F))));
    const F chroma = V::sub(one, V::abs(V::sub(V::add(x, x), one)));
    F colour[3];
    for (int c = 0; c < 3; ++c) colour[c] = V::madd(chroma, part.appearance[c], x);
    if constexpr (kShade) shade(part.sample.cell, counts, colour);
    for (int c = 0; c < 3; ++c) rgb_[c] = V::madd(beta, V::sub(colour[c], rgb_[c]), rgb_[c]);
    image_ = V::sub(image_, V::mul(beta, image_));
    alpha_ = V::madd(V::sub(one, alpha_), opacity, alpha_);
    if constexpr (kBlend != PredicateBlend::kOver) {
      paid_ = V::select(V::both(counts, V::less(importance_, next)), zero, paid_);
    }
    importance_ = V::select(counts, next, importance_);
  }

  const PredicateInputs& in_;
  RayPacket& rays_;
  PredicateRays& more_;
  int lane_;
  MarchCounts& counts_;
  Sampler<V> sampler_;
  Bricks<V> bricks_;
  Fading<V> fading_;
  F begin_;
  F end_;
  F rgb_[3];
  F alpha_;
  F image_;
  F importance_;
  F left_out_;              ///< spec::LeftOut::spent.
  F paid_ = V::set(0.0F);   ///< spec::LeftOut::paid.
  F until_{};               ///< sure_ and ask_ are known for the cells in front of this.
  std::uint32_t sure_ = 0;  ///< Leaves that are true in these cells.
  std::uint32_t ask_ = 0;   ///< Leaves that must be tested.
  F greatest_ = V::set(0.0F);
  F greatest_until_ = V::set(-1e30F);
};

template <class V, PredicateBlend kBlend, bool kFade, bool kShade>
void march_predicates(const PredicateInputs& in, RayPacket& rays, PredicateRays& more,
                      MarchCounts& counts) {
  for (int lane = 0; lane < kPacketLanes; lane += V::kLanes) {
    PredicateMarcher<V, kBlend, kFade, kShade>(in, rays, more, lane, counts).march();
  }
}

template <class V, PredicateBlend kBlend>
PredicateMarch predicate_march(bool fade, bool shade) {
  if (shade) {
    return fade ? march_predicates<V, kBlend, true, true>
                : march_predicates<V, kBlend, false, true>;
  }
  return fade ? march_predicates<V, kBlend, true, false>
              : march_predicates<V, kBlend, false, false>;
}

template <class V>
PredicateMarch predicate_march(PredicateBlend blend, bool fade, bool shade) {
  switch (blend) {
    case PredicateBlend::kOver:
      return predicate_march<V, PredicateBlend::kOver>(fade, shade);
    case PredicateBlend::kWeight:
      return predicate_march<V, PredicateBlend::kWeight>(fade, shade);
    case PredicateBlend::kLog:
      return predicate_march<V, PredicateBlend::kLog>(fade, shade);
  }
  return nullptr;
}

}  // namespace nav::render
