// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_leap.hpp"

/// Several cells taken as one. See cpu_kernel.hpp for V and for where this may be included.
namespace nav::render {

/// How many cells from one on are a segment: the rule of adaptive_step.hpp. Bricks are left a
/// little early, as by leaps.
template <class V>
struct Segments {
  using F = typename V::F;
  using M = typename V::M;

  Bricks<V> bricks;
  F known;  ///< Up to here, exclusively, the brick is the same.
  F most;   ///< Cells of a segment in it.

  Segments(const Sampler<V>& sampler, F first) : bricks(sampler), known(first), most(first) {}

  /// single: lanes that keep single cells; begin, end: of the stretch.
  F cells(F cell, F begin, F end, M active, M single) {
    const M open = V::both(active, V::not_less(cell, known));
    if (V::any(open)) {
      const auto brick = bricks.find(cell);
      const F allowed = V::to_float(V::load_byte(bricks.sampler.in.brick_cells, brick.at));
      known = V::select(open, bricks.leave(brick, cell), known);
      most = V::select(open, allowed, most);
    }
    const F one = V::set(1.0F);
    const F last = V::min(V::sub(known, one), V::floor(end));
    const F m = V::max(V::min(most, V::sub(last, cell)), one);
    return V::select(V::either(single, V::less(cell, begin)), one, m);
  }
};

}  // namespace nav::render
