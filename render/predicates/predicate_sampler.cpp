// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/predicate_sampler.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "nav/index.hpp"
#include "render/features/labels.hpp"

namespace nav::render {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Eigen::Vector3d clamped(const VoxelGrid& grid, Eigen::Vector3d index) {
  for (int axis = 0; axis < 3; ++axis) {
    index[axis] = std::clamp(index[axis], 0.0, static_cast<double>(grid.size[as_size(axis)] - 1));
  }
  return index;
}

}  // namespace

double PredicateSampler::value(std::size_t channel, const Eigen::Vector3d& index) const {
  const PredicateSet::Channel& c = set_.channels()[channel];
  const VoxelGrid& grid = c.codes->grid();
  const Eigen::Vector3d at = clamped(grid, index);
  const std::span<const std::int16_t> codes = c.codes->values();
  std::array<std::array<std::size_t, 2>, 3> near{};
  Eigen::Vector3d w;
  std::size_t stride = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const int n = grid.size[as_size(axis)];
    const int low = static_cast<int>(at[axis]);
    w[axis] = at[axis] - low;
    near[as_size(axis)] = {as_size(low) * stride, as_size(std::min(low + 1, n - 1)) * stride};
    stride *= as_size(n);
  }
  bool undefined = false;
  const auto row = [&](std::size_t y, std::size_t z) {
    const std::int16_t a = codes[near[0][0] + near[1][y] + near[2][z]];
    const std::int16_t b = codes[near[0][1] + near[1][y] + near[2][z]];
    undefined = undefined || a == FeatureVolume::kUndefined || b == FeatureVolume::kUndefined;
    return a + w.x() * (b - a);
  };
  const auto slice = [&](std::size_t z) {
    const double a = row(0, z);
    return a + w.y() * (row(1, z) - a);
  };
  const double a = slice(0);
  const double code = a + w.z() * (slice(1) - a);
  return undefined && c.has_undefined ? kNaN : c.offset + c.scale * code;
}

std::uint32_t PredicateSampler::leaves(const Eigen::Vector3d& index) const {
  const VoxelGrid& grid = set_.place().grid;
  const Eigen::Vector3d at = clamped(grid, index);
  PredicateSample sample{{kNaN, kNaN}, {0, 0}, 0, grid.spacing_mm.cwiseProduct(at)};
  if (set_.labels() && set_.labels()->layers()) {
    sample.labels = std::uint32_t{1} << set_.labels()->layers()->layer_at(at);
  } else if (set_.labels()) {
    std::size_t offset = 0;
    for (int axis = 2; axis >= 0; --axis) {
      offset =
          offset * as_size(grid.size[as_size(axis)]) + static_cast<std::size_t>(at[axis] + 0.5);
    }
    sample.labels = set_.labels()->bits()[offset];
  }
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < set_.leaves().size(); ++i) {
    const PredicateSet::Leaf& leaf = set_.leaves()[i];
    for (std::size_t c = 0; c < leaf.channels.size(); ++c) {
      const auto channel = as_size(leaf.channels[c]);
      sample.value[c] = value(channel, at);
      sample.quantum[c] = set_.channels()[channel].quantum;
    }
    if (set_.test(leaf, sample)) bits |= 1U << i;
  }
  return bits;
}

namespace {

/// Index of a voxel; i fastest.
Eigen::Vector3d index_of(const VoxelGrid& grid, std::size_t voxel) {
  const std::size_t row = voxel / as_size(grid.size[0]);
  return {static_cast<double>(voxel % as_size(grid.size[0])),
          static_cast<double>(row % as_size(grid.size[1])),
          static_cast<double>(row / as_size(grid.size[1]))};
}

}  // namespace

SharedImportance shared_importance(const PredicateSet& set) {
  SharedImportance shared{set.most_important()};
  constexpr std::size_t kVoxels = 20000;
  constexpr std::size_t kFar = 2654435761;  // Knuth: spreads successive numbers far apart.
  constexpr double kFully = 1 - 1e-6;
  const VoxelGrid& grid = set.place().grid;
  const std::size_t count = grid.voxel_count();
  const PredicateSampler sampler(set);
  std::size_t is = 0;
  std::size_t less = 0;
  double sum = 0;
  for (std::size_t n = 0; n < std::min(kVoxels, count); ++n) {
    const std::uint32_t mask = sampler.mask(index_of(grid, n * kFar % count));
    if ((mask >> shared.entry & 1U) == 0) continue;
    ++is;
    const double importance = set.class_of(mask).importance / set.greatest_impact();
    if (importance >= kFully) continue;
    ++less;
    sum += importance;
  }
  if (less == 0) return shared;
  shared.share = static_cast<double>(less) / static_cast<double>(is);
  shared.importance = sum / static_cast<double>(less);
  return shared;
}

std::vector<std::uint64_t> count_true(const PredicateSet& set,
                                      std::span<const std::size_t> voxels) {
  const PredicateSampler sampler(set);
  const VoxelGrid& grid = set.place().grid;
  std::vector<std::uint64_t> counts(set.size());
  for (const std::size_t v : voxels) {
    NAV_CHECK(v < grid.voxel_count(), v);
    const std::uint32_t mask = sampler.mask(index_of(grid, v));
    for (std::size_t j = 0; j < counts.size(); ++j) counts[j] += (mask >> j) & 1U;
  }
  return counts;
}

IntensityOpacity::IntensityOpacity(double opacity_length_mm) : tau_(PredicateScene::kTauEntries) {
  for (std::size_t i = 0; i < tau_.size(); ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(tau_.size() - 1);
    tau_[i] = static_cast<float>(-std::log1p(-std::min(x, PredicateScene::kMostOpacity)) /
                                 opacity_length_mm);
  }
}

double IntensityOpacity::tau(double intensity) const {
  const double last = static_cast<double>(tau_.size() - 1);
  const double x = std::clamp(intensity, 0.0, 1.0) * last;
  const auto i = std::min(static_cast<std::size_t>(x), tau_.size() - 2);
  const double below = tau_[i];
  return below + (x - static_cast<double>(i)) * (static_cast<double>(tau_[i + 1]) - below);
}

}  // namespace nav::render
