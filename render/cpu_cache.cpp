// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_cache.hpp"

#include <algorithm>

namespace nav::render {
namespace {

constexpr std::size_t kTail = 3;  // A brick's byte is fetched as the first of four.

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
    importance_.resize(importance_.size() + kTail);
  }
}

void CpuCache::make_leaps(int threads) {
  distances_ = brick_distances(*bricks_, *table_, threads);
  shell_ = brick_shell(*bricks_, *distances_, threads);
  if (!part_ranges_) part_ranges_ = make_part_grid(*ct_, threads);
  parts_ = visible_parts(*part_ranges_, *bricks_, *distances_, *table_, threads);
  // How far all bricks around are occupied in all their parts.
  BrickDistances whole = *distances_;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    if (parts_[b] != 0xFF) whole.distance[b] = 1;
  }
  parts_.resize(parts_.size() + kTail);
  const std::vector<std::uint8_t> depths = brick_depths(*bricks_, whole, threads);
  leaps_.resize(depths.size() + kTail);
  for (std::size_t b = 0; b < depths.size(); ++b) {
    const int distance = std::min<int>(distances_->distance[b], 127);
    const int depth = std::clamp<int>(depths[b], 1, 127);
    leaps_[b] = static_cast<std::int8_t>(distance > 0 ? distance : 1 - depth);
  }
}

void CpuCache::make_cells(const AdaptiveStep& adaptive, int threads) {
  if (cells_of_ == adaptive) return;
  if (!bricks_) bricks_ = make_brick_grid(*ct_, threads);
  cells_ = brick_cells(*bricks_, *table_, adaptive, threads);
  cells_.resize(cells_.size() + kTail);
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
