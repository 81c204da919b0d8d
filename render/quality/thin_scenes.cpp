// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/thin_scenes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "render/parallel.hpp"
#include "render/two_volumes.hpp"

namespace nav::render {
namespace {

constexpr int kFewestToThin = 16;  // Shorter axes keep all voxels.
/// A cell of just less than a voxel: rays may skip single cells that show nothing.
constexpr double kThinStepVoxels = 0.95;
/// Greatest difference of two voxels of one material, HU: noise and gradual changes.
constexpr int kOneMaterial = 150;

using ThinStride = std::array<int, 3>;

/// Mean of a voxel and of those around it that are of its material, with binomial weights along the
/// axes that are thinned.
std::int16_t material_mean(const StoredVolume& volume, const std::array<int, 3>& at,
                           const ThinStride& stride) {
  const auto& size = volume.grid().size;
  const std::int16_t* voxels = volume.values().data();
  const auto index = [&](int i, int j, int k) {
    return (as_size(k) * as_size(size[1]) + as_size(j)) * as_size(size[0]) + as_size(i);
  };
  const int own = voxels[index(at[0], at[1], at[2])];
  std::array<int, 3> low{}, high{};
  for (std::size_t a = 0; a < 3; ++a) {
    // Both neighbours or none, so that the middle stays where it is.
    const int reach = stride[a] == 2 && at[a] > 0 && at[a] + 1 < size[a] ? 1 : 0;
    low[a] = at[a] - reach;
    high[a] = at[a] + reach;
  }
  int sum = 0;
  int weights = 0;
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) {
        const int value = voxels[index(i, j, k)];
        if (std::abs(value - own) > kOneMaterial) continue;
        const int weight = (i == at[0] ? 2 : 1) * (j == at[1] ? 2 : 1) * (k == at[2] ? 2 : 1);
        sum += weight * (value - own);
        weights += weight;
      }
    }
  }
  return static_cast<std::int16_t>(
      own + static_cast<int>(std::lround(static_cast<double>(sum) / weights)));
}

}  // namespace

std::shared_ptr<const StoredVolume> every_second_voxel(const StoredVolume& volume) {
  const VoxelGrid& grid = volume.grid();
  VoxelGrid thin = grid;
  ThinStride stride{};
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t at = as_size(axis);
    stride[at] = grid.size[at] < kFewestToThin ? 1 : 2;
    thin.size[at] = (grid.size[at] + stride[at] - 1) / stride[at];
    thin.spacing_mm[axis] *= stride[at];
  }
  std::vector<std::int16_t> voxels(thin.voxel_count());
  for_each_index(thin.size[2], 0, [&](int k) {
    std::size_t to = as_size(k) * as_size(thin.size[1]) * as_size(thin.size[0]);
    for (int j = 0; j < thin.size[1]; ++j) {
      for (int i = 0; i < thin.size[0]; ++i) {
        voxels[to++] = material_mean(volume, {i * stride[0], j * stride[1], k * stride[2]}, stride);
      }
    }
  });
  auto made = StoredVolume::create(thin, std::move(voxels), volume.name());
  NAV_CHECK(made, volume.name());
  return std::make_shared<const StoredVolume>(*std::move(made));
}

std::optional<Scene> ThinScenes::of(const Scene& scene) {
  if (drawn_by_predicates(scene) || has_two_volumes(scene)) return std::nullopt;
  thin_out(scene.ct, ct_);
  thin_out(scene.gradient_source, gradients_);
  Scene thin = scene;
  thin.ct = ct_.thin;
  thin.gradient_source = gradients_.thin;
  thin.quality.step_voxels = std::max(kThinStepVoxels, scene.quality.step_voxels);
  return thin;
}

void ThinScenes::thin_out(const std::shared_ptr<const StoredVolume>& whole, Thin& kept) {
  if (kept.whole == whole) return;
  kept = {whole, whole ? every_second_voxel(*whole) : nullptr};
}

}  // namespace nav::render
