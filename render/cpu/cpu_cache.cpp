// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_cache.hpp"

#include <algorithm>

#include "nav/index.hpp"
#include "render/parallel.hpp"

namespace nav::render {
namespace {

/// Least share of invisible cells, among the cells in visible parts of bricks, from which on the
/// march tests single cells: measured (ADR 46).
constexpr double kLeastHiddenShare = 0.1;
/// Greatest step as a share of a block's edge. The difference to 1 exceeds rounding errors.
constexpr double kMostOfAnEdge = 0.95;

/// Edge of the blocks of cells that a march with single cells may skip; 0: none.
int cell_edge(const Quality& quality, const TransferTable& table) {
  // A cell has only one sample.
  if (table.rows() > 1 || quality.classification == Classification::kPostClassified) return 1;
  for (const int edge : {1, 2}) {
    if (quality.step_voxels <= kMostOfAnEdge * edge) return edge;
  }
  return 0;
}

/// Number of cells in the visible parts of occupied bricks. \p parts: visible_parts().
std::size_t cells_in_parts(const std::vector<std::uint8_t>& parts, const BrickDistances& distances,
                           const Eigen::Vector3i& bricks, const VoxelGrid& grid) {
  const auto inside = [&](int axis, int brick, unsigned half) {
    const int first = kBrickVoxels * brick + (half != 0 ? kPartVoxels : 0);
    return as_size(std::clamp(grid.size[as_size(axis)] - first, 0, kPartVoxels));
  };
  std::size_t cells = 0;
  std::size_t b = 0;
  for (int k = 0; k < bricks.z(); ++k) {
    for (int j = 0; j < bricks.y(); ++j) {
      for (int i = 0; i < bricks.x(); ++i, ++b) {
        if (distances.distance[b] > 0) continue;
        for (unsigned bit = 0; bit < 8; ++bit) {
          if ((parts[b] >> bit & 1) == 0) continue;
          cells += inside(0, i, bit & 1) * inside(1, j, bit & 2) * inside(2, k, bit & 4);
        }
      }
    }
  }
  return cells;
}

std::vector<std::int32_t> packed_ranges(const BrickGrid& bricks) {
  std::vector<std::int32_t> out(bricks.low.size());
  for (std::size_t b = 0; b < out.size(); ++b) {
    out[b] = bricks.high[b] * 65536 + static_cast<std::uint16_t>(bricks.low[b]);
  }
  return out;
}

}  // namespace

void CpuCache::update(const Scene& scene, bool with_cutaway, int threads) {
  const bool new_volume = ct_ != scene.ct;
  if (new_volume) take_volume(scene, threads);
  if (gradients_of_ != scene.gradient_source) {
    gradients_of_ = scene.gradient_source;
    gradients_.reset();
    if (gradients_of_) gradients_.emplace(*gradients_of_, threads);
  }
  const bool new_transfer = !transfer_ || !same_classification(*transfer_, scene.transfer);
  if (new_transfer) take_transfer(scene);
  if ((new_volume || new_transfer) && table_->rows() == 1) {
    integrals_ = march_integrals(*table_, volume_->low_hu(), volume_->high_hu());
  }
  cell_edge_ = 0;
  if (!scene.quality.skip_empty_bricks) return;
  if (!bricks_) bricks_ = make_brick_grid(*ct_, threads);
  if (scene.projection != Projection::kComposite) {
    if (ranges_.empty()) ranges_ = packed_ranges(*bricks_);
    return;
  }
  if (!distances_) make_leaps(threads);
  find_visible_cells(scene.quality, threads);
  if (with_cutaway && importance_.empty()) {
    importance_ = brick_importance(*bricks_, *table_, threads);
    importance_.resize(importance_.size() + kBrickTail);
  }
  if (with_cutaway && scene.cutaway->constant) never_hidden_.assign(importance_.size(), 255);
}

void CpuCache::make_leaps(int threads) {
  if (!part_ranges_) part_ranges_ = make_part_grid(*ct_, threads);
  const std::vector<std::uint8_t> hidden = hidden_bricks(*bricks_, *table_, threads);
  parts_ = visible_parts(*part_ranges_, *bricks_, hidden, *table_, threads);
  shell_ = brick_shell(*bricks_, hidden, threads);
  // Distance, in bricks, within which all bricks are occupied in all their parts.
  std::vector<std::uint8_t> depths;
  const auto find_depths = [&] {
    std::vector<std::uint8_t> partly = hidden;
    std::transform(partly.begin(), partly.end(), parts_.begin(), partly.begin(),
                   [](std::uint8_t hides, std::uint8_t parts) {
                     return static_cast<std::uint8_t>(parts != 0xFF ? 1 : hides);
                   });
    depths = brick_depths(*bricks_, partly);
  };
  for_each_index(2, threads, [&](int map) {
    if (map == 0) return find_depths();
    distances_ = brick_distances(*bricks_, hidden);
  });
  leaps_.resize(depths.size() + kBrickTail);
  std::transform(distances_->distance.begin(), distances_->distance.end(), depths.begin(),
                 leaps_.begin(), [](std::uint8_t distance, std::uint8_t depth) {
                   const int least = std::min<int>(distance, 127);
                   const int deep = std::clamp<int>(depth, 1, 127);
                   return static_cast<std::int8_t>(least > 0 ? least : 1 - deep);
                 });
  parts_.resize(parts_.size() + kBrickTail);
}

void CpuCache::find_visible_cells(const Quality& quality, int threads) {
  cell_edge_ = cell_edge(quality, *table_);
  if (cell_edge_ == 0 || visible_cells_.contains(cell_edge_)) return;
  const auto voxels = static_cast<double>(ct_->grid().voxel_count());
  if (static_cast<double>(rays_) < kRaysBeforeCells * voxels) return;
  const auto at = visible_cells_.try_emplace(cell_edge_, *ct_, *volume_, *distances_, *table_,
                                             cell_edge_, threads);
  VisibleCells& cells = at.first->second;
  const std::size_t looked_at = cells_in_parts(parts_, *distances_, bricks_->count, ct_->grid());
  const double most = (1 - kLeastHiddenShare) * static_cast<double>(looked_at);
  if (static_cast<double>(cells.count()) > most) cells.release();
}

const std::int32_t* CpuCache::visible_cells() const {
  const auto found = visible_cells_.find(cell_edge_);
  return found == visible_cells_.end() ? nullptr : found->second.words();
}

void CpuCache::forget_visible_cells() {
  visible_cells_.clear();
  rays_ = 0;
}

void CpuCache::take_volume(const Scene& scene, int threads) {
  volume_.emplace(*scene.ct, threads);
  ct_ = scene.ct;
  bricks_.reset();
  part_ranges_.reset();
  distances_.reset();
  forget_visible_cells();
  importance_.clear();
  ranges_.clear();
}

void CpuCache::take_transfer(const Scene& scene) {
  transfer_ = scene.transfer;
  table_.emplace(scene.transfer);
  entries_ = march_entries(*table_);
  distances_.reset();
  forget_visible_cells();
  importance_.clear();
}

}  // namespace nav::render
