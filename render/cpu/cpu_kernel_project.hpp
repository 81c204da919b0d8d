// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_leap.hpp"

/// Greatest, least and mean values along rays. See cpu_kernel.hpp for V and for the files that may
/// include this.
namespace nav::render {

/// A value this far outside the range of a brick cannot come from it, even with rounding, HU.
inline constexpr float kRangeMargin = 1.0F / 64;

template <class V, MarchProject kProject>
class Projector {
  using F = typename V::F;
  using M = typename V::M;
  static constexpr bool kMean = kProject == MarchProject::kMean;

 public:
  Projector(const MarchInputs& inputs, const RayPacket& rays, int lane, MarchCounts& counts)
      : in_(inputs),
        counts_(counts),
        sampler_(inputs, rays, lane),
        begin_(V::load(rays.begin + lane)),
        end_(V::load(rays.end + lane)) {}

  /// The projected value, HU; undefined for rays that miss the volume.
  F project() {
    F cell = V::floor(begin_);
    M active = V::less(begin_, end_);
    const Bricks<V> bricks(sampler_);
    const bool skipping = !kMean && in_.brick_range != nullptr;
    F found = V::set(kProject == MarchProject::kMaximum   ? -1e9F
                     : kProject == MarchProject::kMinimum ? 1e9F
                                                          : 0.0F);
    F known = cell;
    while (V::any(active)) {
      if (skipping) {
        cell = skip(bricks, cell, found, active, known);
        active = V::both(active, V::less(cell, end_));
      }
      counts_.samples += static_cast<std::uint64_t>(V::count(active));
      found = V::select(active, add(cell, found), found);
      cell = V::add(cell, V::set(1.0F));
      active = V::both(active, V::less(cell, end_));
    }
    if constexpr (kMean) found = V::div(found, V::max(V::sub(end_, begin_), V::set(1e-20F)));
    // Rays whose length in the volume is lost in single precision, or that miss the volume.
    const M short_ones = V::negate(V::less(begin_, end_));
    return V::any(short_ones) ? V::select(short_ones, sampler_.value(begin_), found) : found;
  }

 private:
  F add(F cell, F found) const {
    const F value = sampler_.value(cell);
    if constexpr (kProject == MarchProject::kMaximum) return V::max(found, value);
    if constexpr (kProject == MarchProject::kMinimum) return V::min(found, value);
    const F next = V::add(cell, V::set(1.0F));
    const F length = V::sub(V::min(next, end_), V::max(cell, begin_));
    return V::madd(value, length, found);
  }

  /// First cell, from \p cell on, whose brick may change the found value.
  F skip(const Bricks<V>& bricks, F cell, F found, M active, F& known) const {
    M open = V::both(V::both(active, V::less(cell, end_)), V::not_less(cell, known));
    while (V::any(open)) {
      const auto brick = bricks.find(cell);
      F low;
      F high;
      V::load_range(in_.brick_range, brick.at, low, high);
      const F leave = bricks.leave(brick, cell);
      const M useless = kProject == MarchProject::kMaximum
                            ? V::less(V::add(high, V::set(kRangeMargin)), found)
                            : V::less(found, V::sub(low, V::set(kRangeMargin)));
      known = V::select(open, leave, known);
      open = V::both(open, useless);
      cell = V::select(open, leave, cell);
      open = V::both(open, V::less(cell, end_));
    }
    return cell;
  }

  const MarchInputs& in_;
  MarchCounts& counts_;
  Sampler<V> sampler_;
  F begin_;
  F end_;
};

template <class V, MarchProject kProject>
void project_with(const MarchInputs& in, RayPacket& rays, MarchCounts& counts) {
  for (int lane = 0; lane < kPacketLanes; lane += V::kLanes) {
    V::store(rays.value + lane, Projector<V, kProject>(in, rays, lane, counts).project());
  }
}

/// The instance for a projection.
template <class V>
March project_march(MarchProject project) {
  switch (project) {
    case MarchProject::kMaximum:
      return project_with<V, MarchProject::kMaximum>;
    case MarchProject::kMinimum:
      return project_with<V, MarchProject::kMinimum>;
    case MarchProject::kMean:
      return project_with<V, MarchProject::kMean>;
  }
  return nullptr;
}

}  // namespace nav::render
