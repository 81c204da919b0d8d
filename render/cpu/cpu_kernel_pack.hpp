// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_shade.hpp"

/// Shading of few lanes at a time, packed side by side. See cpu_kernel.hpp for V and for the files
/// that may include this. V also has pack(), unpack(), pick() and first_lanes().
namespace nav::render {

/// Positions on rays to be shaded, at most those of a run of cells. The shade of a position does
/// not depend on its neighbours in the pack.
template <class V, MarchShade kShade>
class ShadePack {
  using F = typename V::F;
  using I = typename V::I;
  using M = typename V::M;
  static constexpr int kRoom = (kMarchRun * kMarchMostShades + 1) * V::kLanes;

 public:
  /// Adds a position of every open lane, in cells, and its colour before shading.
  void add(F at, const F* rgb, F share, M open) {
    V::pack(at_ + count_, open, at);
    V::pack(lane_ + count_, open, V::lane_numbers());
    V::pack(share_ + count_, open, share);
    for (int c = 0; c < 3; ++c) V::pack(rgb_[c] + count_, open, rgb[c]);
    count_ += V::count(open);
  }

  void shade(const Sampler<V>& sampler) {
    Sampler<V> picked = sampler;
    for (int first = 0; first < count_; first += V::kLanes) {
      const M needed = V::first_lanes(count_ - first);
      const I lane = V::truncate(V::load(lane_ + first));
      for (int axis = 0; axis < 3; ++axis) {
        picked.origin[axis] = V::pick(sampler.origin[axis], lane);
        picked.step[axis] = V::pick(sampler.step[axis], lane);
      }
      F gradient[3];
      picked.gradient(V::load(at_ + first), needed, gradient);
      F full[3];
      for (int c = 0; c < 3; ++c) full[c] = V::load(rgb_[c] + first);
      Shader<V, kShade>{picked}.shade(gradient, V::load(share_ + first), full);
      for (int c = 0; c < 3; ++c) V::store(rgb_[c] + first, full[c]);
    }
  }

  /// Returns the shades of the lanes that were added first and not taken yet; 0 in the other lanes.
  void take(M open, F* shades) {
    for (int c = 0; c < 3; ++c) shades[c] = V::unpack(rgb_[c] + taken_, open);
    taken_ += V::count(open);
  }

 private:
  alignas(64) float at_[kRoom];
  alignas(64) float lane_[kRoom];
  alignas(64) float share_[kRoom];
  alignas(64) float rgb_[3][kRoom];
  int count_ = 0;
  int taken_ = 0;
};

}  // namespace nav::render
