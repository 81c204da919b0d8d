// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/coarse_volumes.hpp"

#include <algorithm>
#include <bit>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "render/parallel.hpp"

namespace nav::render {
namespace {

constexpr int kFewestVoxels = 16;  // Shorter axes keep all voxels.
constexpr int kMostHalved = 384;   // Axes up to this size keep every second voxel.

int stride_of(int n) {
  if (n < kFewestVoxels) return 1;
  return n <= kMostHalved ? 2 : 4;
}

bool is_power_of_two(int n) { return std::has_single_bit(static_cast<unsigned>(n)); }

template <class T>
std::vector<T> every_nth(std::span<const T> voxels, const VoxelGrid& whole,
                         const VoxelGrid& coarse) {
  std::vector<T> out(coarse.voxel_count());
  const auto row = as_size(whole.size[0]);
  const auto coarse_row = as_size(coarse.size[0]);
  const auto stride = as_size(stride_of(whole.size[0]));
  for_each_index(coarse.size[2], 0, [&](int k) {
    for (int j = 0; j < coarse.size[1]; ++j) {
      const int from_slice = k * stride_of(whole.size[2]);
      const int from_row = j * stride_of(whole.size[1]);
      const T* from =
          voxels.data() + (as_size(from_slice) * as_size(whole.size[1]) + as_size(from_row)) * row;
      T* to = out.data() + (as_size(k) * as_size(coarse.size[1]) + as_size(j)) * coarse_row;
      for (std::size_t i = 0; i < coarse_row; ++i) to[i] = from[stride * i];
    }
  });
  return out;
}

std::shared_ptr<const StoredVolume> every_nth(const StoredVolume& whole) {
  const VoxelGrid coarse = coarse_grid(whole.grid());
  auto made =
      StoredVolume::create(coarse, every_nth(whole.values(), whole.grid(), coarse), whole.name());
  NAV_CHECK(made, whole.name());
  return std::make_shared<const StoredVolume>(*std::move(made));
}

}  // namespace

VoxelGrid coarse_grid(const VoxelGrid& grid) {
  VoxelGrid coarse = grid;
  for (int axis = 0; axis < 3; ++axis) {
    const int n = grid.size[as_size(axis)];
    const int stride = stride_of(n);
    int count = (n + stride - 1) / stride;
    if (is_power_of_two(count) && !is_power_of_two(n)) --count;
    coarse.size[as_size(axis)] = count;
    coarse.spacing_mm[axis] = stride * grid.spacing_mm[axis];
  }
  return coarse;
}

Scene CoarseVolumes::of(const Scene& scene, const PredicateSet& set) {
  if (volume_ != scene.ct) {
    release();
    coarse_ = every_nth(*scene.ct);
    volume_ = scene.ct;
  }
  Scene out = scene;
  out.ct = coarse_;
  coarsen_features(set, out.predicates->features);
  coarsen_labels(set, out.predicates->features);
  coarsen_gradients(out.predicates->shading);
  return out;
}

/// Coarsens the features that the set reads, or has read before. Others are not offered.
void CoarseVolumes::coarsen_features(const PredicateSet& set, Features& offered) {
  const auto asks_for = [&](const StoredVolume* codes) {
    return std::any_of(set.channels().begin(), set.channels().end(),
                       [&](const auto& channel) { return channel.codes.get() == codes; });
  };
  std::map<const StoredVolume*, CoarseFeature> kept;
  for (const auto& [name, whole] : offered.volumes) {
    const StoredVolume* codes = whole.codes().get();
    if (auto known = features_.extract(codes); !known.empty()) {
      kept.insert(std::move(known));
    } else if (kept.count(codes) == 0 && asks_for(codes)) {
      kept.emplace(codes, CoarseFeature{whole, whole.with_codes(every_nth(*whole.codes()))});
    }
  }
  features_ = std::move(kept);
  std::erase_if(offered.volumes, [&](const auto& named) {
    return features_.count(named.second.codes().get()) == 0;
  });
  for (auto& named : offered.volumes) {
    named.second = features_.at(named.second.codes().get()).coarse;
  }
}

void CoarseVolumes::coarsen_labels(const PredicateSet& set, Features& offered) {
  offered.labels.reset();
  if (!set.labels()) return;
  const LabelVolume& whole = *set.labels();
  if (!labels_ || labels_->of.bits().data() != whole.bits().data()) {
    const VoxelGrid& grid = coarse_->grid();
    auto coarse =
        LabelVolume::create(grid, every_nth(whole.bits(), whole.grid(), grid), whole.name());
    NAV_CHECK(coarse, whole.name());
    labels_.emplace(CoarseLabels{whole, *std::move(coarse)});
  }
  offered.labels = labels_->coarse;
}

void CoarseVolumes::coarsen_gradients(std::optional<PredicateShading>& shading) {
  const auto& source = shading ? shading->source : nullptr;
  if (gradients_ != source) {
    gradients_ = source;
    coarse_gradients_ = source ? every_nth(*source) : nullptr;
  }
  if (shading) shading->source = coarse_gradients_;
}

void CoarseVolumes::release() {
  volume_.reset();
  coarse_.reset();
  features_.clear();
  labels_.reset();
  gradients_.reset();
  coarse_gradients_.reset();
}

}  // namespace nav::render
