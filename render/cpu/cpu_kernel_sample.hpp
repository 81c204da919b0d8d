// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_march.hpp"

/// Values and gradients of the volume along a packet of rays. See cpu_kernel.hpp for V and for the
/// files that may include this.
namespace nav::render {

template <class V>
struct Sampler {
  using F = typename V::F;
  using I = typename V::I;

  const MarchInputs& in;
  F origin[3];
  F step[3];

  Sampler(const MarchInputs& inputs, const RayPacket& rays, int lane) : in(inputs) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = V::load(rays.origin[axis] + lane);
      step[axis] = V::load(rays.step[axis] + lane);
    }
  }

  struct Place {
    I base;  ///< Offset of the lower voxel.
    F w[3];  ///< Fractions towards the next voxel.
  };

  F coordinate(int axis, F at) const {
    const F p = V::madd(at, step[axis], origin[axis]);
    return V::min(V::max(p, V::set(0.0F)), V::set(in.last[axis]));
  }

  /// Position of the sample at \p at, in cells, in the volume.
  Place locate(F at) const {
    Place c;
    I index[3];
    for (int axis = 0; axis < 3; ++axis) {
      const F p = coordinate(axis, at);
      index[axis] = V::truncate(p);
      c.w[axis] = V::sub(p, V::to_float(index[axis]));
    }
    c.base = V::add(V::add(V::mul(index[2], V::set_int(in.slice_stride)),
                           V::mul(index[1], V::set_int(in.row_stride))),
                    index[0]);
    return c;
  }

  static F lerp(F a, F b, F w) { return V::madd(w, V::sub(b, a), a); }

  /// Interpolates the rows that V::load_cells() loaded.
  static F interpolate(const F (*v)[2], const Place& c) {
    F rows[4];
    for (int i = 0; i < 4; ++i) rows[i] = lerp(v[i][0], v[i][1], c.w[0]);
    return lerp(lerp(rows[0], rows[1], c.w[1]), lerp(rows[2], rows[3], c.w[1]), c.w[2]);
  }

  /// Value of the sample at \p at, HU.
  F value(F at) const { return value(locate(at)); }
  F value(const Place& c) const {
    F v[4][2];
    V::load_cells(in.voxels, in.slice_stride, c.base, v);
    return interpolate(v, c);
  }

  /// Prefetches the voxels of the cells, two memory lines each. prefetch_cells() does so for every
  /// lane. prefetch_corners() does so only for the corners of a packet, because the cells between
  /// them mostly lie on the same lines. They are always inlined, because GCC could otherwise drop
  /// calls that have no result.
  __attribute__((always_inline)) static void prefetch_cells(const std::int32_t* voxels, int slice,
                                                            typename V::I at) {
    const typename V::Lanes lanes(at);
    for (const auto lane : lanes.at) prefetch_cell(voxels + lane, slice);
  }
  __attribute__((always_inline)) static void prefetch_corners(const std::int32_t* voxels, int slice,
                                                              typename V::I at) {
    const typename V::Lanes lanes(at);
    constexpr int kLast = V::kLanes - 1;
    constexpr int kRow = kLast < kPacketWidth ? kLast : kPacketWidth - 1;
    prefetch_cell(voxels + lanes.at[0], slice);
    if constexpr (kLast > 0) prefetch_cell(voxels + lanes.at[kLast], slice);
    if constexpr (kLast > kRow) {
      prefetch_cell(voxels + lanes.at[kRow], slice);
      prefetch_cell(voxels + lanes.at[kLast - kRow], slice);
    }
  }
  __attribute__((always_inline)) static void prefetch_cell(const std::int32_t* voxel, int slice) {
    __builtin_prefetch(voxel);
    __builtin_prefetch(voxel + slice);
  }

  /// Lanes whose sample lies in a cell of voxels that may be visible.
  typename V::M visible(const Place& c) const { return V::load_bit(in.visible_cells, c.base); }

  /// Gradient, HU/mm, along the axes of the grid, in which the ray's direction is also known.
  /// Undefined in lanes that do not need it.
  void gradient(F at, typename V::M needed, F* g) const {
    const Place c = locate(at);
    V::differences(in.gradient_voxels, in.row_stride, in.slice_stride, c.base, c.w, needed, g);
    for (int axis = 0; axis < 3; ++axis)
      g[axis] = V::mul(g[axis], V::set(in.half_per_spacing[axis]));
  }

  static F length(const F* g) {
    return V::sqrt(V::madd(g[0], g[0], V::madd(g[1], g[1], V::mul(g[2], g[2]))));
  }

  /// g · ray direction; the direction has unit length.
  F along_ray(const F* g) const {
    F dot = V::set(0.0F);
    for (int axis = 0; axis < 3; ++axis) {
      dot = V::madd(g[axis], V::mul(step[axis], V::set(in.mm_per_index_step[axis])), dot);
    }
    return dot;
  }
};

}  // namespace nav::render
