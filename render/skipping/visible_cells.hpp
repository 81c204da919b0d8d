// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nav/volume.hpp"
#include "render/cpu/cpu_volume.hpp"
#include "render/skipping/brick_grid.hpp"
#include "render/transfer/transfer_table.hpp"

namespace nav::render {

/// They are found once so many rays have been cast for each voxel of a volume with a transfer
/// function: until then that would have taken longer than it could have saved, and an edit's first
/// picture does not wait for them.
inline constexpr double kRaysBeforeCells = 1.0 / 32;

/// In which cells of a volume, the cubes between eight voxels, a transfer function may show
/// something: one bit each. Where bricks are half empty, most of a ray's samples in them are.
class VisibleCells {
 public:
  /// edge: 1, 2, 4 or 8; of a block of edge^3 cells all are visible or none. Two samples less than
  /// edge voxels apart along every axis lie in blocks that have a voxel in common: between two that
  /// are invisible nothing is visible. distances: of the same volume and table. Uses at most
  /// threads threads; 0: all cores.
  VisibleCells(const Volume& ct, const CpuVolume& layout, const BrickDistances& distances,
               const TransferTable& table, int edge, int threads);

  /// Bit (o mod 32) of word o / 32 is the cell whose lower voxel lies o from layout.origin().
  /// Null once released.
  [[nodiscard]] const std::int32_t* words() const {
    return words_.empty() ? nullptr : words_.data();
  }
  /// Visible cells.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Lets go of the bits.
  void release() { words_ = {}; }

 private:
  std::vector<std::int32_t> words_;
  std::size_t count_ = 0;
};

}  // namespace nav::render
