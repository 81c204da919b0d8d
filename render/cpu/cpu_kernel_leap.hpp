// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_sample.hpp"

/// Leaps over invisible cells. See cpu_kernel.hpp for V and for the files that may include this.
namespace nav::render {

/// Distance inside the faces of a brick at which a leap ends, voxels. It exceeds the rounding error
/// of a position anywhere in a volume of 2^14 voxels per axis. So a leap never passes over a sample
/// that marching would have taken, and skipping is bit-identical to not skipping.
inline constexpr float kLeapMargin = 1.0F / 64;

/// A step below this, in voxels, changes no position on any ray.
inline constexpr float kStill = 1e-20F;

/// Bricks along a packet of rays. Leaps wait for one another, so everything that does not depend on
/// a brick's entry is computed before that entry is fetched.
template <class V>
struct Bricks {
  using F = typename V::F;
  using I = typename V::I;
  using M = typename V::M;

  /// Position of the face through which rays leave a cube, along one axis: cells per voxel, and
  /// cells for a cube of 8 or 4 voxels at the origin. It is far away if the rays do not move along
  /// the axis.
  struct Axis {
    F per_voxel;
    F of_8;
    F of_4;
    F per_brick;  ///< Additional cells for a cube that is larger by one brick on all sides.
  };

  const Sampler<V>& sampler;
  Axis axes[3];

  explicit Bricks(const Sampler<V>& s) : sampler(s) {
    const F margin = V::set(kLeapMargin);
    const F nothing = V::set(0.0F);
    for (int i = 0; i < 3; ++i) {
      const F step = s.step[i];
      const M moves = V::less(V::set(kStill), V::abs(step));
      const M forward = V::less(nothing, step);
      const F per = V::div(V::set(1.0F), V::select(moves, step, V::set(1.0F)));
      const auto leave = [&](float side) {
        const F face = V::select(forward, V::sub(V::set(side), margin), margin);
        return V::select(moves, V::mul(V::sub(face, s.origin[i]), per), V::set(1e9F));
      };
      axes[i].per_voxel = V::mask(moves, per);
      axes[i].of_8 = leave(8);
      axes[i].of_4 = leave(4);
      axes[i].per_brick = V::mask(moves, V::mul(V::set(8.0F), V::abs(per)));
    }
  }

  struct Brick {
    I voxel[3];  ///< Voxel of a sample in the brick.
    I at;        ///< Position in the arrays of bricks.
  };

  /// The brick that holds a sample.
  Brick find(F sample) const {
    Brick b;
    I index[3];
    for (int axis = 0; axis < 3; ++axis) {
      b.voxel[axis] = V::truncate(sampler.coordinate(axis, sample));
      index[axis] = V::shift_right_3(b.voxel[axis]);
    }
    const MarchInputs& in = sampler.in;
    const I slice = V::mul(index[2], V::set_int(in.bricks[1] * in.bricks[0]));
    b.at = V::add(slice, V::add(V::mul(index[1], V::set_int(in.bricks[0])), index[0]));
    return b;
  }

  /// True when the bit of the part that holds the brick's sample is set in \p parts.
  static M among(const Brick& brick, I parts) {
    const auto half = [&](int axis) { return V::bits(brick.voxel[axis], 4); };
    const I bit = V::add(
        V::add(V::shift_right(half(0), V::set_int(2)), V::shift_right(half(1), V::set_int(1))),
        half(2));
    return V::less(V::set(0.0F), V::to_float(V::bits(V::shift_right(parts, bit), 1)));
  }

  /// First sample after \p sample that may lie outside the cube of \p reach bricks around its own
  /// brick.
  F leave(const Brick& brick, F reach, F sample) const {
    F out = V::set(1e9F);
    for (int i = 0; i < 3; ++i) {
      const F low = V::to_float(V::bits(brick.voxel[i], ~7));
      const F own = V::madd(low, axes[i].per_voxel, axes[i].of_8);
      out = V::min(out, V::madd(reach, axes[i].per_brick, own));
    }
    return after(out, sample);
  }
  /// First sample after \p sample that may lie outside its own brick.
  F leave(const Brick& brick, F sample) const { return leave(brick, V::set(0.0F), sample); }
  /// First sample after \p sample that may lie outside the cube or, in halved lanes, outside its
  /// part of the brick.
  F leave(const Brick& brick, F reach, F sample, M halved) const {
    F out = V::set(1e9F);
    for (int i = 0; i < 3; ++i) {
      const F low = V::to_float(V::bits(brick.voxel[i], ~3));
      out = V::min(out, V::madd(low, axes[i].per_voxel, axes[i].of_4));
    }
    return V::select(halved, after(out, sample), leave(brick, reach, sample));
  }

 private:
  static F after(F out, F sample) {
    const F one = V::set(1.0F);
    return V::max(V::add(V::floor(out), one), V::add(sample, one));
  }
};

/// The range in which the cutaway hides samples of little importance: spec::visible_from(), in
/// cells, minus the margin for rounding.
template <class V>
struct Hiding {
  using F = typename V::F;

  F t1;
  F t2;
  F margin;

  Hiding(const RayPacket& rays, int lane)
      : t1(V::load(rays.t1 + lane)),
        t2(V::load(rays.t2 + lane)),
        margin(V::load(rays.margin + lane)) {}

  /// \p importance: in steps of 1/254; 255 for samples that are never hidden.
  F up_to(F importance, float overlay_cells) const {
    const F twice = V::mul(importance, V::set(2.0F / 254));
    const F one = V::set(1.0F);
    const F outer = V::sub(t2, V::mul(twice, V::sub(t2, t1)));
    const F inner = V::sub(t1, V::mul(V::sub(twice, one), V::set(overlay_cells)));
    const F up = V::sub(V::select(V::less(one, twice), inner, outer), margin);
    return V::select(V::less(V::set(254.0F), importance), V::set(-1e30F), up);
  }
};

/// Moves rays from cell to cell and skips all invisible cells. A post-classified cell is invisible
/// if its sample lies in a brick that is empty, or that the cutaway hides for longer than the cell.
/// A pre-integrated cell is invisible if both of its ends do.
template <class V, bool kBothEnds, bool kFade>
struct Leaper {
  using F = typename V::F;
  using I = typename V::I;
  using M = typename V::M;

  Bricks<V> bricks;
  Hiding<V> hiding;
  F known;  ///< Cells in front of this are marched without a test.

  Leaper(const Sampler<V>& sampler, const RayPacket& rays, int lane, F first)
      : bricks(sampler), hiding(rays, lane), known(first) {}

  /// First sample after those that show nothing; \p sample itself if it may show something.
  /// Undefined in lanes that are not open. Behind the outer surface the cutaway is not tested.
  F beyond(F sample, M open, F& leave) const {
    const MarchInputs& in = bricks.sampler.in;
    const auto brick = bricks.find(sample);
    const F range = V::to_float(V::load_signed_byte(in.brick_leap, brick.at));
    M empty = V::less(V::set(0.0F), range);
    F reach = V::max(V::sub(range, V::set(1.0F)), V::sub(V::set(0.0F), range));
    // Samples hidden by the cutaway are skipped brick by brick.
    bool hides = false;
    if constexpr (kFade) {
      const M behind = V::not_less(sample, hiding.t2);
      hides = V::any(V::both(open, V::negate(behind)));
      if (hides) reach = V::select(V::either(empty, behind), reach, V::set(0.0F));
    }
    if (in.brick_parts != nullptr) {
      const I parts = V::load_byte(in.brick_parts, brick.at);
      const M halved = V::less(V::to_float(parts), V::set(255.0F));
      empty = V::either(empty, V::both(halved, V::negate(Bricks<V>::among(brick, parts))));
      leave = bricks.leave(brick, reach, sample, halved);
    } else {
      leave = bricks.leave(brick, reach, sample);
    }
    if (!hides) return V::select(empty, leave, sample);
    const F importance = V::to_float(V::load_byte(in.brick_importance, brick.at));
    // Cells that end at samples up to here are hidden, and so is the next cell.
    const F hidden = V::floor(hiding.up_to(importance, in.overlay_cells));
    return V::select(empty, leave, V::max(sample, V::min(leave, hidden)));
  }

  /// Moves the cells of active lanes forward and marks these lanes in moved. True when a lane
  /// moved.
  bool leap(F& cell, F end, M active, M& moved) {
    const F back = V::set(kBothEnds ? 1.0F : 0.0F);
    M open = V::both(V::both(active, V::less(cell, end)), V::not_less(cell, known));
    if (!V::any(open)) return false;
    F sample = cell;
    while (V::any(open)) {
      F leave;
      const F next = beyond(sample, open, leave);
      const M free = V::less(sample, next);
      known = V::select(V::both(open, V::negate(free)), leave, known);
      sample = V::select(V::both(open, free), next, sample);
      open = V::both(V::both(open, free), V::less(V::sub(sample, back), end));
    }
    const F there = V::sub(sample, back);
    const M on = V::both(active, V::less(cell, there));
    cell = V::select(on, there, cell);
    moved = V::either(moved, on);
    return V::any(on);
  }
};

}  // namespace nav::render
