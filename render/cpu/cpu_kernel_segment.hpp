// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_leap.hpp"

/// Several cells taken as one. See cpu_kernel.hpp for V and for the files that may include this.
namespace nav::render {

/// Number of cells that form a segment: the rule of adaptive_step.hpp. As in leaps, bricks are left
/// a little early.
template <class V>
struct Segments {
  using F = typename V::F;
  using M = typename V::M;

  Bricks<V> bricks;
  F known;  ///< The brick stays the same up to here, exclusive.
  F most;   ///< Greatest number of cells of a segment in the brick.

  Segments(const Sampler<V>& sampler, F first) : bricks(sampler), known(first), most(first) {}

  /// Cells of the segment at \p cell. \p single: lanes that keep single cells; \p begin, \p end:
  /// ends of the marched interval.
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
