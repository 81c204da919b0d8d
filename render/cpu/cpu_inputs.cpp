// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_inputs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nav::render {
namespace {

static_assert(kBrickVoxels == 8, "The march finds a sample's brick by a shift of 3 bits.");

/// Greatest total colour error of a ray from samples that stay unshaded because each of them has
/// too little weight.
constexpr double kShadingBudget = 1.0 / 512;

/// Greatest length of a pre-integrated cell whose ends always lie in the same brick or in
/// neighbours. The ranges of neighbours overlap, so nothing is visible between ends in two empty
/// bricks. 8 voxels minus a margin for rounding.
constexpr double kLongestLeapableCell = 7.5;
/// The corresponding length for parts of bricks.
constexpr double kLongestCellOverParts = 3.5;

/// Number of voxels that are marched between two brick tests: measured, the best of 1 to 4. The
/// second value is for runs of cells.
constexpr double kVoxelsPerTest = 2;
constexpr double kVoxelsPerTestInRuns = 4;
constexpr double kMostRunsPerTest = 8;

/// Replaces infinity, because infinity · 0 would be NaN.
constexpr double kFar = 1e30;
/// Limits for prefetching the voxels of the next run. All are prefetched for volumes of more voxels
/// than kPrefetchVoxels, or than kPrefetchVoxelsFar if the step is at least kPrefetchFrom voxels.
/// Otherwise those at the corners of packets are prefetched for more than kPrefetchVoxelsAtCorners.
/// Measured (ADR 40, 43, 48).
constexpr std::size_t kPrefetchVoxels = 24'000'000;
constexpr double kPrefetchFrom = 1.2;
constexpr std::size_t kPrefetchVoxelsFar = 2'000'000;
constexpr std::size_t kPrefetchVoxelsAtCorners = 3'000'000;

void set_grid(const Scene& scene, const CpuCache& cache, MarchInputs& in) {
  const VoxelGrid& grid = scene.ct->grid();
  const double step = spec::step_mm(scene.quality, grid);
  in.voxels = cache.volume().origin();
  in.gradient_voxels = cache.gradient_volume().origin();
  in.row_stride = cache.volume().row_stride();
  in.slice_stride = cache.volume().slice_stride();
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    in.last[axis] = static_cast<float>(grid.size[a] - 1);
    in.half_per_spacing[axis] = static_cast<float>(0.5 / grid.spacing_mm[axis]);
    in.mm_per_index_step[axis] = static_cast<float>(grid.spacing_mm[axis] / step);
  }
  in.step_mm = static_cast<float>(step);
  in.prefetch = march_prefetch(grid, scene.quality);
  in.opaque_at = scene.quality.opaque_at < 1 ? static_cast<float>(scene.quality.opaque_at)
                                             : std::numeric_limits<float>::infinity();
}

void set_bricks(const Scene& scene, const CpuCache& cache, const MarchKey& key, MarchInputs& in) {
  if (cache.bricks()) std::copy_n(cache.bricks()->count.data(), 3, in.bricks);
  if (!scene.quality.skip_empty_bricks) return;
  if (scene.projection != Projection::kComposite) {
    in.brick_range = cache.ranges().data();
    return;
  }
  if (key.classify == MarchClassify::kPreIntegrated &&
      scene.quality.step_voxels > kLongestLeapableCell) {
    return;
  }
  in.brick_leap = cache.leaps().data();
  if (scene.quality.step_voxels <= kLongestCellOverParts) in.brick_parts = cache.parts().data();
  if (key.cells == MarchCells::kVisible) in.visible_cells = cache.visible_cells();
  const bool in_runs = key.classify == MarchClassify::kPreIntegrated;
  in.cells_per_test =
      in_runs ? cells_per_test_in_runs(scene.quality) : cells_per_test(scene.quality);
  // A run without visible cells costs little, and brick tests cannot skip the other runs.
  if (key.cells == MarchCells::kVisible) in.cells_per_test *= 2;
  // Constant thresholds hide by no importance.
  if (key.fade) {
    in.brick_importance =
        scene.cutaway->constant ? cache.never_hidden().data() : cache.importance().data();
  }
}

void set_table(const CpuCache& cache, MarchInputs& in) {
  const TransferTable& table = cache.table();
  in.table = cache.entries().data();
  in.importance = table.importance().data();
  in.table_low_hu = static_cast<float>(table.first_hu());
  in.table_high_hu = static_cast<float>(table.last_hu());
  in.table_size = table.size();
  in.table_rows = table.rows();
  if (table.rows() > 1) in.rows_per_gradient = static_cast<float>(1 / table.gradient_per_row());
  in.invisible_up_to_hu = static_cast<float>(table.invisible_up_to_hu());
  in.integrals = cache.integrals().entries.data();
  in.quantum = cache.integrals().quantum;
}

void set_shading(const Scene& scene, MarchInputs& in) {
  const VoxelGrid& grid = scene.ct->grid();
  const Shading& shading = scene.shading;
  const auto view = spec::make_view<double>(scene.camera, scene.width, scene.height, grid);
  const Eigen::Vector3d light = grid.directions.transpose() * spec::gooch_light(view);
  for (int axis = 0; axis < 3; ++axis) in.light[axis] = static_cast<float>(light[axis]);
  set_light(shading, in);
  // A ray crosses at most diagonal / step + 2 cells.
  const double cells = grid.extent_mm().norm() / spec::step_mm(scene.quality, grid) + 2;
  in.min_shaded_weight = static_cast<float>(kShadingBudget / cells);
  in.shades_per_root =
      static_cast<float>(spec::kShadesPerRoot * std::sqrt(scene.quality.step_voxels));
}

/// Converts a vector to the axes of the grid, in voxels per mm.
void set_index_axis(const Eigen::Vector3d& v, const VoxelGrid& grid, double* out) {
  const Eigen::Vector3d index = (grid.directions.transpose() * v).cwiseQuotient(grid.spacing_mm);
  std::copy_n(index.data(), 3, out);
}

}  // namespace

void set_light(const Shading& shading, MarchInputs& in) {
  in.per_full_gradient = static_cast<float>(1 / shading.full_gradient_per_mm);
  in.emphasis = static_cast<float>(shading.emphasis);
  in.ambient = static_cast<float>(shading.ambient);
  in.diffuse = static_cast<float>(shading.diffuse);
  in.specular = static_cast<float>(shading.specular);
  in.shininess = static_cast<float>(shading.shininess);
  const bool whole = shading.shininess == std::floor(shading.shininess);
  in.whole_shininess = whole ? static_cast<int>(shading.shininess) : -1;
  // The greatest computed power has an exponent below 2 · shininess.
  in.least_cosine = static_cast<float>(std::pow(10.0, -37 / std::max(2 * shading.shininess, 1.0)));
  in.cool_share = static_cast<float>(shading.cool_share);
  in.warm_share = static_cast<float>(shading.warm_share);
  in.silhouette = static_cast<float>(shading.silhouette);
}

void set_thresholds(const Cutaway& cutaway, MarchInputs& in) {
  in.fade_share = cutaway.constant ? 0.0F : 1.0F;
  in.fade_low = cutaway.constant ? static_cast<float>(cutaway.constant->lower) : 0.0F;
  in.fade_high = cutaway.constant ? static_cast<float>(cutaway.constant->upper) : 0.0F;
}

int cells_per_test(const Quality& quality) {
  const double cells = std::round(kVoxelsPerTest / quality.step_voxels);
  return static_cast<int>(std::clamp(cells, 1.0, 16.0));
}

MarchPrefetch march_prefetch(const VoxelGrid& grid, const Quality& quality) {
  const std::size_t voxels = grid.voxel_count();
  const bool far_apart = quality.step_voxels >= kPrefetchFrom;
  if (voxels > (far_apart ? kPrefetchVoxelsFar : kPrefetchVoxels)) return MarchPrefetch::kAll;
  return voxels > kPrefetchVoxelsAtCorners ? MarchPrefetch::kCorners : MarchPrefetch::kNone;
}

int cells_per_test_in_runs(const Quality& quality) {
  const double runs = std::round(kVoxelsPerTestInRuns / (kMarchRun * quality.step_voxels));
  return kMarchRun * static_cast<int>(std::clamp(runs, 1.0, kMostRunsPerTest));
}

RayInputs ray_inputs(const Scene& scene, double first_sample) {
  const VoxelGrid& grid = scene.ct->grid();
  const auto view = spec::make_view<double>(scene.camera, scene.width, scene.height, grid);
  RayInputs in{};
  set_index_axis(view.eye, grid, in.eye);
  set_index_axis(view.right, grid, in.right);
  set_index_axis(view.up, grid, in.up);
  set_index_axis(view.forward, grid, in.forward);
  in.pixel = 2 * view.half_height / view.height;
  in.half_width = 0.5 * view.width;
  in.half_height = 0.5 * view.height;
  in.orthographic = view.orthographic;
  in.width = view.width;
  in.height = view.height;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    in.low[axis] = grid.size[axis] > 1 ? 0 : -0.5;
    in.high[axis] = grid.size[axis] > 1 ? grid.size[axis] - 1 : 0.5;
  }
  in.step_mm = spec::step_mm(scene.quality, grid);
  in.first_sample = first_sample;
  in.jitter = scene.quality.jitter;
  return in;
}

MarchKey march_key(const Scene& scene, const CpuCache& cache, bool with_cutaway) {
  MarchKey key{MarchClassify::kPreIntegrated, MarchShade::kNone, with_cutaway, MarchCells::kAll};
  if (cache.visible_cells() != nullptr) key.cells = MarchCells::kVisible;
  if (cache.table().rows() > 1) {
    key.classify = MarchClassify::kWindows;
  } else if (scene.quality.classification == Classification::kPostClassified) {
    key.classify = MarchClassify::kPostClassified;
  }
  // If all weights of the shading are exactly 0, the march without shading gives the same result.
  if (scene.shading.enabled && cache.table().shades(scene.shading.emphasis)) {
    key.shade =
        scene.shading.style == ShadingStyle::kPhong ? MarchShade::kPhong : MarchShade::kGooch;
  }
  return key;
}

MarchInputs march_inputs(const Scene& scene, const CpuCache& cache, const MarchKey& key) {
  MarchInputs in{};
  set_grid(scene, cache, in);
  set_bricks(scene, cache, key, in);
  set_table(cache, in);
  set_shading(scene, in);
  if (key.fade) {
    const double overlay =
        scene.cutaway->overlay_mm / spec::step_mm(scene.quality, scene.ct->grid());
    in.overlay_cells = static_cast<float>(std::min(overlay, kFar));
    in.per_overlay = static_cast<float>(std::min(1 / overlay, kFar));
    set_thresholds(*scene.cutaway, in);
  }
  return in;
}

}  // namespace nav::render
