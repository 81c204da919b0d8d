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
#include "render/quality/adaptive_step.hpp"
#include "render/scene.hpp"
#include "render/skipping/brick_grid.hpp"
#include "render/skipping/visible_cells.hpp"
#include "render/skipping/visible_spans.hpp"
#include "render/transfer/transfer_table.hpp"

namespace nav::render {

/// What the CPU engine keeps from one picture to the next: everything that follows from the volume
/// and the transfer function, made when a scene first needs it.
class CpuCache {
 public:
  /// Prepares for a validated scene whose volume fits. with_cutaway: something of it will be cut.
  void update(const Scene& scene, bool with_cutaway, int threads);
  /// So many rays of the last scene were cast: what costs as much as many rays is made once they
  /// were many.
  void count_rays(std::uint64_t rays) { rays_ += rays; }

  [[nodiscard]] const CpuVolume& volume() const { return *volume_; }
  [[nodiscard]] const TransferTable& table() const { return *table_; }
  [[nodiscard]] const std::vector<TableEntry>& entries() const { return entries_; }
  [[nodiscard]] const MarchIntegrals& integrals() const { return integrals_; }
  /// Absent until a scene asked for skipping.
  [[nodiscard]] const std::optional<BrickGrid>& bricks() const { return bricks_; }
  /// Absent until a composited scene asked for skipping.
  [[nodiscard]] const std::optional<BrickDistances>& distances() const { return distances_; }
  /// As MarchInputs::brick_leap, like distances().
  [[nodiscard]] const std::vector<std::int8_t>& leaps() const { return leaps_; }
  /// As MarchInputs::brick_parts, like distances().
  [[nodiscard]] const std::vector<std::uint8_t>& parts() const { return parts_; }
  /// As MarchInputs::visible_cells, for the last scene's step; null: none, so far or at all.
  [[nodiscard]] const std::int32_t* visible_cells() const;
  /// Like distances().
  [[nodiscard]] const BrickShell& shell() const { return shell_; }
  /// Empty until a scene with a cutaway asked for skipping.
  [[nodiscard]] const std::vector<std::uint8_t>& importance() const { return importance_; }
  /// As MarchInputs::brick_cells; of the last scene with an adaptive step.
  [[nodiscard]] const std::vector<std::uint8_t>& cells() const { return cells_; }
  /// As MarchInputs::brick_range; empty until a projection asked for skipping.
  [[nodiscard]] const std::vector<std::int32_t>& ranges() const { return ranges_; }

 private:
  void make_leaps(int threads);
  void make_cells(const AdaptiveStep& adaptive, int threads);
  void find_visible_cells(const Quality& quality, int threads);
  void forget_visible_cells();
  void take_volume(const Scene& scene, int threads);
  void take_transfer(const Scene& scene);

  std::shared_ptr<const Volume> ct_;  ///< Held, so that its address stays its own.
  std::optional<CpuVolume> volume_;
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
  std::map<int, VisibleCells> visible_cells_;  ///< By the edges of their blocks.
  int cell_edge_ = 0;                          ///< Of the last scene; 0: none.
  std::uint64_t rays_ = 0;                     ///< Cast of this volume with this transfer function.
  std::vector<std::uint8_t> importance_;
  std::vector<std::int32_t> ranges_;
  std::vector<std::uint8_t> cells_;
  std::optional<AdaptiveStep> cells_of_;  ///< What cells_ were made for.
};

}  // namespace nav::render
