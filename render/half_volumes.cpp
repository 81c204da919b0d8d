// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/half_volumes.hpp"

#include <algorithm>
#include <bit>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "render/parallel.hpp"

namespace nav::render {
namespace {

constexpr int kFewestVoxels = 16;  // Of an axis that is halved.

int stride_of(int n) { return n < kFewestVoxels ? 1 : 2; }

bool is_power_of_two(int n) { return std::has_single_bit(static_cast<unsigned>(n)); }

template <class T>
std::vector<T> every_second(std::span<const T> voxels, const VoxelGrid& whole,
                            const VoxelGrid& half) {
  std::vector<T> out(half.voxel_count());
  const auto row = as_size(whole.size[0]);
  const auto half_row = as_size(half.size[0]);
  const auto stride = as_size(stride_of(whole.size[0]));
  for_each_index(half.size[2], 0, [&](int k) {
    for (int j = 0; j < half.size[1]; ++j) {
      const int from_slice = k * stride_of(whole.size[2]);
      const int from_row = j * stride_of(whole.size[1]);
      const T* from =
          voxels.data() + (as_size(from_slice) * as_size(whole.size[1]) + as_size(from_row)) * row;
      T* to = out.data() + (as_size(k) * as_size(half.size[1]) + as_size(j)) * half_row;
      for (std::size_t i = 0; i < half_row; ++i) to[i] = from[stride * i];
    }
  });
  return out;
}

std::shared_ptr<const Volume> every_second(const Volume& whole) {
  const VoxelGrid half = half_grid(whole.grid());
  auto made = Volume::create(half, every_second(whole.hu(), whole.grid(), half), whole.name());
  NAV_CHECK(made, whole.name());
  return std::make_shared<const Volume>(*std::move(made));
}

}  // namespace

VoxelGrid half_grid(const VoxelGrid& grid) {
  VoxelGrid half = grid;
  for (int axis = 0; axis < 3; ++axis) {
    const int n = grid.size[as_size(axis)];
    const int stride = stride_of(n);
    int count = (n + stride - 1) / stride;
    if (is_power_of_two(count) && !is_power_of_two(n)) --count;
    half.size[as_size(axis)] = count;
    half.spacing_mm[axis] = stride * grid.spacing_mm[axis];
  }
  return half;
}

Scene HalfVolumes::of(const Scene& scene, const PredicateSet& set) {
  if (volume_ != scene.ct) {
    release();
    half_ = every_second(*scene.ct);
    volume_ = scene.ct;
  }
  Scene out = scene;
  out.ct = half_;
  halve_features(set, out.predicates->features);
  halve_labels(set, out.predicates->features);
  return out;
}

/// What is not asked for, and never was, is not offered.
void HalfVolumes::halve_features(const PredicateSet& set, Features& offered) {
  const auto asks_for = [&](const Volume* codes) {
    return std::any_of(set.channels().begin(), set.channels().end(),
                       [&](const auto& channel) { return channel.codes.get() == codes; });
  };
  std::map<const Volume*, HalfFeature> kept;
  for (const auto& [name, whole] : offered.volumes) {
    const Volume* codes = whole.codes().get();
    if (auto known = features_.extract(codes); !known.empty()) {
      kept.insert(std::move(known));
    } else if (kept.count(codes) == 0 && asks_for(codes)) {
      kept.emplace(codes, HalfFeature{whole, whole.with_codes(every_second(*whole.codes()))});
    }
  }
  features_ = std::move(kept);
  std::erase_if(offered.volumes, [&](const auto& named) {
    return features_.count(named.second.codes().get()) == 0;
  });
  for (auto& named : offered.volumes) {
    named.second = features_.at(named.second.codes().get()).half;
  }
}

void HalfVolumes::halve_labels(const PredicateSet& set, Features& offered) {
  offered.labels.reset();
  if (!set.labels()) return;
  const LabelVolume& whole = *set.labels();
  if (!labels_ || labels_->of.bits().data() != whole.bits().data()) {
    const VoxelGrid& grid = half_->grid();
    auto half =
        LabelVolume::create(grid, every_second(whole.bits(), whole.grid(), grid), whole.name());
    NAV_CHECK(half, whole.name());
    labels_.emplace(HalfLabels{whole, *std::move(half)});
  }
  offered.labels = labels_->half;
}

void HalfVolumes::release() {
  volume_.reset();
  half_.reset();
  features_.clear();
  labels_.reset();
}

}  // namespace nav::render
