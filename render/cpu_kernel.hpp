// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu_march.hpp"

/// The march of ray_spec.hpp in single precision, written once for any number of lanes. V supplies
/// the arithmetic: V::F (floats), V::I (32-bit integers), V::M (lane mask), of V::kLanes lanes.
/// Include only from the files that define a V in an unnamed namespace: then every instance has
/// internal linkage and stays in the file whose instruction set it was compiled for.
namespace nav::render {

/// A brick's leap ends this far inside of its faces, voxels: more than the rounding of a position
/// anywhere in a volume of 2^14 voxels per axis, so that a leap never passes over a sample that
/// marching would have taken. Skipping is therefore bit-identical to not skipping.
inline constexpr float kLeapMargin = 1.0F / 64;

/// A step below this, in voxels, changes no position along any ray.
inline constexpr float kStill = 1e-20F;

template <class V>
struct Marcher {
  using F = typename V::F;
  using I = typename V::I;
  using M = typename V::M;

  const MarchInputs& in;
  F origin[3];
  F step[3];

  struct Cell {
    I base;  ///< Offset of the lower voxel.
    F w[3];  ///< Fractions towards the next.
  };

  F coordinate(int axis, F cell) const {
    const F p = V::madd(cell, step[axis], origin[axis]);
    return V::min(V::max(p, V::set(0.0F)), V::set(in.last[axis]));
  }

  Cell locate(F cell) const {
    Cell c;
    I index[3];
    for (int axis = 0; axis < 3; ++axis) {
      const F p = coordinate(axis, cell);
      index[axis] = V::truncate(p);
      c.w[axis] = V::sub(p, V::to_float(index[axis]));
    }
    c.base = V::add(V::add(V::mul(index[2], V::set_int(in.slice_stride)),
                           V::mul(index[1], V::set_int(in.row_stride))),
                    index[0]);
    return c;
  }

  static F lerp(F a, F b, F w) { return V::madd(w, V::sub(b, a), a); }

  /// Row of two voxels at an offset, interpolated along x.
  F row(const Cell& c, int offset) const {
    F a;
    F b;
    V::load_pair(in.voxels + offset, c.base, a, b);
    return lerp(a, b, c.w[0]);
  }

  /// The four rows around a sample, interpolated along x, and their central differences along x.
  struct Rows {
    F value[4];
    F difference[4];
  };

  int row_offset(int y, int z) const { return y * in.row_stride + z * in.slice_stride; }

  Rows rows_with_difference(const Cell& c) const {
    Rows r;
    for (int i = 0; i < 4; ++i) {
      F before;
      F a;
      F b;
      F after;
      V::load_quad(in.voxels + row_offset(i & 1, i >> 1) - 1, c.base, before, a, b, after);
      r.value[i] = lerp(a, b, c.w[0]);
      r.difference[i] = V::sub(lerp(b, after, c.w[0]), lerp(before, a, c.w[0]));
    }
    return r;
  }

  Rows rows(const Cell& c) const {
    Rows r;
    for (int i = 0; i < 4; ++i) r.value[i] = row(c, row_offset(i & 1, i >> 1));
    return r;
  }

  static F bilinear(const F* r, const Cell& c) {
    return lerp(lerp(r[0], r[1], c.w[1]), lerp(r[2], r[3], c.w[1]), c.w[2]);
  }

  /// Shaded colour: Blinn–Phong with a headlight on the central-difference gradient. The gradient
  /// is taken along the axes of the grid, where the ray's direction is known as well.
  void shade(const Cell& c, const Rows& r, F* rgb) const {
    F g[3];
    g[0] = V::mul(bilinear(r.difference, c), V::set(in.half_per_spacing[0]));
    F y[2];
    for (int z = 0; z < 2; ++z) {
      const F below = row(c, row_offset(-1, z));
      const F above = row(c, row_offset(2, z));
      const F* centre = r.value + 2 * z;
      y[z] = V::sub(lerp(centre[1], above, c.w[1]), lerp(below, centre[0], c.w[1]));
    }
    g[1] = V::mul(lerp(y[0], y[1], c.w[2]), V::set(in.half_per_spacing[1]));
    const F below = lerp(row(c, row_offset(0, -1)), row(c, row_offset(1, -1)), c.w[1]);
    const F above = lerp(row(c, row_offset(0, 2)), row(c, row_offset(1, 2)), c.w[1]);
    const F first = lerp(r.value[0], r.value[1], c.w[1]);
    const F second = lerp(r.value[2], r.value[3], c.w[1]);
    g[2] = V::mul(V::sub(lerp(second, above, c.w[2]), lerp(below, first, c.w[2])),
                  V::set(in.half_per_spacing[2]));

    F square = V::mul(g[0], g[0]);
    square = V::madd(g[1], g[1], V::madd(g[2], g[2], square));
    F dot = V::set(0.0F);
    for (int axis = 0; axis < 3; ++axis) {
      dot = V::madd(g[axis], V::mul(step[axis], V::set(in.mm_per_index_step[axis])), dot);
    }
    const F norm = V::sqrt(square);
    // A zero gradient has weight 0: the quotient only has to be finite.
    const F cosine = V::min(V::set(1.0F), V::div(V::abs(dot), V::max(norm, V::set(1e-20F))));
    const F weight = V::min(V::set(1.0F), V::mul(norm, V::set(in.per_full_gradient)));
    const F lit = V::madd(cosine, V::set(in.diffuse), V::set(in.ambient));
    const F gloss = V::mul(V::set(in.specular), V::power(cosine, in.shininess));
    for (int channel = 0; channel < 3; ++channel) {
      const F full = V::max(V::set(0.0F), V::min(V::set(1.0F), V::madd(rgb[channel], lit, gloss)));
      rgb[channel] = lerp(rgb[channel], full, weight);
    }
  }

  /// Follows each of the lanes that stand at the start of an unknown stretch (cell >= known) out of
  /// empty bricks, to the first cell of an occupied one; known becomes the end of that brick.
  void leap(F& cell, F& known, F end, const F* per_step, M active) const {
    for (;;) {
      const M open = V::both(V::both(active, V::less(cell, end)), V::not_less(cell, known));
      if (!V::any(open)) return;
      I brick[3];
      for (int axis = 0; axis < 3; ++axis) {
        brick[axis] = V::shift_right_3(V::truncate(coordinate(axis, cell)));
      }
      const I at = V::add(V::mul(V::add(V::mul(brick[2], V::set_int(in.bricks[1])), brick[1]),
                                 V::set_int(in.bricks[0])),
                          brick[0]);
      const I distance = V::load_byte(in.brick_distance, at);
      const I reach = V::max_int(V::add(distance, V::set_int(-1)), V::set_int(0));
      F leave = V::set(1e9F);
      for (int axis = 0; axis < 3; ++axis) {
        const F low = V::to_float(V::shift_left_3(V::subtract(brick[axis], reach)));
        const F high =
            V::to_float(V::shift_left_3(V::add(V::add(brick[axis], reach), V::set_int(1))));
        const M forward = V::less(V::set(0.0F), step[axis]);
        const F face =
            V::select(forward, V::sub(high, V::set(kLeapMargin)), V::add(low, V::set(kLeapMargin)));
        const F there = V::mul(V::sub(face, origin[axis]), per_step[axis]);
        const M moves = V::less(V::set(kStill), V::abs(step[axis]));
        leave = V::min(leave, V::select(moves, there, leave));
      }
      const F one = V::set(1.0F);
      const F next = V::max(V::add(V::floor(leave), one), V::add(cell, one));
      const M empty = V::less(V::set(0.0F), V::to_float(distance));
      cell = V::select(V::both(open, empty), next, cell);
      known = V::select(V::both(open, V::negate(empty)), next, known);
    }
  }

  void march(RayPacket& rays, int lane, MarchCounts& counts) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = V::load(rays.origin[axis] + lane);
      step[axis] = V::load(rays.step[axis] + lane);
    }
    const F begin = V::load(rays.begin + lane);
    const F end = V::load(rays.end + lane);
    F alpha = V::load(rays.alpha + lane);
    F rgb[3];
    for (int c = 0; c < 3; ++c) rgb[c] = V::load(rays.rgb[c] + lane);

    const F opaque = V::set(in.opaque_at);
    const F one = V::set(1.0F);
    F cell = V::floor(begin);
    M active = V::both(V::less(begin, end), V::less(alpha, opaque));
    const bool skipping = in.brick_distance != nullptr;
    F known = cell;
    F per_step[3];
    for (int axis = 0; axis < 3; ++axis) per_step[axis] = inverse_step(step[axis]);

    while (V::any(active)) {
      if (skipping) {
        leap(cell, known, end, per_step, active);
        active = V::both(active, V::less(cell, end));
        if (!V::any(active)) break;
      }
      counts.samples += static_cast<std::uint64_t>(V::count(active));
      blend(cell, begin, end, active, rgb, alpha, counts);
      cell = V::add(cell, one);
      active = V::both(active, V::both(V::less(cell, end), V::less(alpha, opaque)));
    }
    V::store(rays.alpha + lane, alpha);
    for (int c = 0; c < 3; ++c) V::store(rays.rgb[c] + lane, rgb[c]);
  }

 private:
  static F inverse_step(F s) {
    const M moves = V::less(V::set(kStill), V::abs(s));
    return V::div(V::set(1.0F), V::select(moves, s, V::set(1.0F)));
  }

  /// Adds one cell to the active lanes.
  void blend(F cell, F begin, F end, M active, F* rgb, F& alpha, MarchCounts& counts) const {
    const Cell c = locate(cell);
    const Rows r = in.shading ? rows_with_difference(c) : rows(c);
    const F hu = bilinear(r.value, c);
    if (!V::any(V::both(active, V::less(V::set(in.invisible_up_to_hu), hu)))) return;
    const F x = V::sub(V::min(V::max(hu, V::set(in.table_low_hu)), V::set(in.table_high_hu)),
                       V::set(in.table_low_hu));
    const I index = V::truncate(x);
    F sample[4];
    V::lookup(in.table, index, V::sub(x, V::to_float(index)), sample);
    const F one = V::set(1.0F);
    const F length = V::sub(V::min(V::add(cell, one), end), V::max(cell, begin));
    const F depth = V::mul(V::mul(sample[3], V::set(in.step_mm)), length);
    const F opacity = V::one_minus_exp(V::max(depth, V::set(0.0F)));
    const F weight = V::mask(active, V::mul(opacity, V::sub(one, alpha)));
    if (in.shading) {
      const M shaded = V::less(V::set(in.min_shaded_weight), weight);
      if (V::any(shaded)) {
        counts.gradients += static_cast<std::uint64_t>(V::count(shaded));
        F full[3] = {sample[0], sample[1], sample[2]};
        shade(c, r, full);
        for (int i = 0; i < 3; ++i) sample[i] = V::select(shaded, full[i], sample[i]);
      }
    }
    for (int i = 0; i < 3; ++i) rgb[i] = V::madd(weight, sample[i], rgb[i]);
    alpha = V::add(alpha, weight);
  }
};

template <class V>
void march_with(const MarchInputs& in, RayPacket& rays, MarchCounts& counts) {
  for (int lane = 0; lane < kPacketLanes; lane += V::kLanes) {
    Marcher<V>{in, {}, {}}.march(rays, lane, counts);
  }
}

}  // namespace nav::render
