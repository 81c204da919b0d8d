// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_cache.hpp"

#include <algorithm>

#include "render/parallel.hpp"

namespace nav::render {
namespace {

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
  const bool new_transfer = !transfer_ || !same_classification(*transfer_, scene.transfer);
  if (new_transfer) take_transfer(scene);
  if ((new_volume || new_transfer) && table_->rows() == 1) {
    integrals_ = march_integrals(*table_, volume_->low_hu(), volume_->high_hu());
  }
  const auto adaptive = adaptive_step(scene, *table_);
  if (adaptive) make_cells(*adaptive, threads);
  if (!scene.quality.skip_empty_bricks) return;
  if (!bricks_) bricks_ = make_brick_grid(*ct_, threads);
  if (scene.projection != Projection::kComposite) {
    if (ranges_.empty()) ranges_ = packed_ranges(*bricks_);
    return;
  }
  if (!distances_) make_leaps(threads);
  if (with_cutaway && importance_.empty()) {
    importance_ = brick_importance(*bricks_, *table_, threads);
    importance_.resize(importance_.size() + kBrickTail);
  }
}

void CpuCache::make_leaps(int threads) {
  if (!part_ranges_) part_ranges_ = make_part_grid(*ct_, threads);
  const std::vector<std::uint8_t> hidden = hidden_bricks(*bricks_, *table_, threads);
  parts_ = visible_parts(*part_ranges_, *bricks_, hidden, *table_, threads);
  shell_ = brick_shell(*bricks_, hidden, threads);
  // How far all bricks around are occupied in all their parts.
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

void CpuCache::make_cells(const AdaptiveStep& adaptive, int threads) {
  if (cells_of_ == adaptive) return;
  if (!bricks_) bricks_ = make_brick_grid(*ct_, threads);
  cells_ = brick_cells(*bricks_, *table_, adaptive, threads);
  cells_.resize(cells_.size() + kBrickTail);
  cells_of_ = adaptive;
}

void CpuCache::take_volume(const Scene& scene, int threads) {
  volume_.emplace(*scene.ct, threads);
  ct_ = scene.ct;
  bricks_.reset();
  part_ranges_.reset();
  cells_of_.reset();
  distances_.reset();
  importance_.clear();
  ranges_.clear();
}

void CpuCache::take_transfer(const Scene& scene) {
  transfer_ = scene.transfer;
  table_.emplace(scene.transfer);
  entries_ = march_entries(*table_);
  cells_of_.reset();
  distances_.reset();
  importance_.clear();
}

}  // namespace nav::render
