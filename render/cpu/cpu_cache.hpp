// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "render/cpu/cpu_transfer.hpp"
#include "render/cpu/cpu_volume.hpp"
#include "render/scene.hpp"
#include "render/skipping/brick_grid.hpp"
#include "render/skipping/visible_cells.hpp"
#include "render/skipping/visible_spans.hpp"
#include "render/transfer/transfer_table.hpp"

namespace nav::render {

/// Data that the CPU engine keeps between images: everything that follows from the volume and the
/// transfer function. It is computed when a scene first needs it.
class CpuCache {
 public:
  /// Prepares for a validated scene whose volume fits. \p with_cutaway: a cutaway will cut it.
  void update(const Scene& scene, bool with_cutaway, int threads);
  /// Counts the rays cast for the last scene. Data that cost as much as many rays are computed only
  /// after many rays.
  void count_rays(std::uint64_t rays) { rays_ += rays; }

  [[nodiscard]] const CpuVolume& volume() const { return *volume_; }
  /// Volume of the gradients: Scene::gradient_source, or the CT. Its strides are those of volume().
  [[nodiscard]] const CpuVolume& gradient_volume() const {
    return gradients_ ? *gradients_ : *volume_;
  }
  [[nodiscard]] const TransferTable& table() const { return *table_; }
  [[nodiscard]] const std::vector<TableEntry>& entries() const { return entries_; }
  [[nodiscard]] const MarchIntegrals& integrals() const { return integrals_; }
  /// No value until a scene requests skipping.
  [[nodiscard]] const std::optional<BrickGrid>& bricks() const { return bricks_; }
  /// No value until a composited scene requests skipping.
  [[nodiscard]] const std::optional<BrickDistances>& distances() const { return distances_; }
  /// See MarchInputs::brick_leap. Available when distances() is.
  [[nodiscard]] const std::vector<std::int8_t>& leaps() const { return leaps_; }
  /// See MarchInputs::brick_parts. Available when distances() is.
  [[nodiscard]] const std::vector<std::uint8_t>& parts() const { return parts_; }
  /// See MarchInputs::visible_cells, for the last scene's step. Null: not computed yet, or not
  /// worth it.
  [[nodiscard]] const std::int32_t* visible_cells() const;
  /// Available when distances() is.
  [[nodiscard]] const BrickShell& shell() const { return shell_; }
  /// Empty until a scene with a cutaway requests skipping.
  [[nodiscard]] const std::vector<std::uint8_t>& importance() const { return importance_; }
  /// MarchInputs::brick_importance of a cutaway that hides by no importance. Empty without one.
  [[nodiscard]] const std::vector<std::uint8_t>& never_hidden() const { return never_hidden_; }
  /// See MarchInputs::brick_range. Empty until a projection requests skipping.
  [[nodiscard]] const std::vector<std::int32_t>& ranges() const { return ranges_; }

 private:
  void make_leaps(int threads);
  void find_visible_cells(const Quality& quality, int threads);
  void forget_visible_cells();
  void take_volume(const Scene& scene, int threads);
  void take_transfer(const Scene& scene);

  std::shared_ptr<const StoredVolume> ct_;  ///< Held so that no other volume gets its address.
  std::optional<CpuVolume> volume_;
  std::shared_ptr<const StoredVolume> gradients_of_;
  std::optional<CpuVolume> gradients_;
  std::optional<TransferFunction> transfer_;
  std::optional<TransferTable> table_;
  std::vector<TableEntry> entries_;
  MarchIntegrals integrals_;
  std::optional<BrickGrid> bricks_;
  std::optional<BrickGrid> part_ranges_;
  std::optional<BrickDistances> distances_;
  BrickShell shell_;
  std::vector<std::int8_t> leaps_;
  std::vector<std::uint8_t> parts_;
  std::map<int, VisibleCells> visible_cells_;  ///< The key is the edge of their blocks.
  int cell_edge_ = 0;                          ///< Edge for the last scene; 0: none.
  std::uint64_t rays_ = 0;  ///< Number of rays cast of this volume with this transfer function.
  std::vector<std::uint8_t> importance_;
  std::vector<std::uint8_t> never_hidden_;
  std::vector<std::int32_t> ranges_;
};

}  // namespace nav::render
