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

/// The number of rays per voxel, cast with one volume and transfer function, after which the
/// visible cells are found. Finding them earlier would take longer than it could save, and the
/// first image after an edit must not wait for it.
inline constexpr double kRaysBeforeCells = 1.0 / 32;

/// The cells of a volume, the cubes between eight voxels, in which a transfer function may show
/// something: one bit each. In half-empty bricks most samples of a ray lie in empty cells.
class VisibleCells {
 public:
  /// Finds the visible cells. edge: 1, 2, 4 or 8; blocks of edge^3 cells are all visible or all
  /// invisible. Two samples less than edge voxels apart along every axis lie in blocks that share a
  /// voxel, so nothing is visible between two invisible samples. distances: of the same volume and
  /// table. Uses at most this many threads; 0: all cores.
  VisibleCells(const StoredVolume& ct, const CpuVolume& layout, const BrickDistances& distances,
               const TransferTable& table, int edge, int threads);

  /// The bits. Bit (o mod 32) of word o / 32 is the cell whose lower voxel lies o from
  /// layout.origin(). Null after release().
  [[nodiscard]] const std::int32_t* words() const {
    return words_.empty() ? nullptr : words_.data();
  }
  /// Number of visible cells.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Frees the bits.
  void release() { words_ = {}; }

 private:
  std::vector<std::int32_t> words_;
  std::size_t count_ = 0;
};

}  // namespace nav::render
