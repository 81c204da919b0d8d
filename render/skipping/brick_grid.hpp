// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nav/volume.hpp"
#include "render/transfer/transfer_table.hpp"

namespace nav::render {

/// Voxels along one edge of a brick. A leap cannot see inside a brick.
inline constexpr int kBrickVoxels = 8;

/// Voxels along one edge of a part, an eighth of a brick.
inline constexpr int kPartVoxels = kBrickVoxels / 2;

/// Bytes after the last brick in a table of one byte per brick: a byte is fetched as the first of
/// four.
inline constexpr std::size_t kBrickTail = 3;

/// Least and greatest HU of every brick of a volume. Brick b holds the trilinear samples whose
/// lower voxel is in [8b, 8b + 8) along each axis, so its range includes one voxel beyond (the
/// apron). Order: i fastest. Shared by the engines that leap over empty bricks. Also used for
/// parts, with 4 instead of 8.
struct BrickGrid {
  Eigen::Vector3i count = Eigen::Vector3i::Zero();  ///< Bricks along i, j, k: (n - 1) / 8 + 1.
  std::vector<std::int16_t> low;
  std::vector<std::int16_t> high;
};
/// Computes the ranges of the bricks on at most this many threads; 0: all cores.
BrickGrid make_brick_grid(const StoredVolume& volume, int threads);
/// Computes the ranges of the parts.
BrickGrid make_part_grid(const StoredVolume& volume, int threads);

/// The bricks [from, to) of a row.
struct BrickSpan {
  int from;
  int to;
};
/// The span from the first to the last occupied brick of a row; occupied bricks are 0. If there is
/// none, from = to.
BrickSpan occupied_span(const std::uint8_t* row, int count);

/// 0 for every brick in which something may be visible, 255 for the hidden ones. Order as in
/// BrickGrid.
std::vector<std::uint8_t> hidden_bricks(const BrickGrid& bricks, const TransferTable& table,
                                        int threads = 0);

/// For every brick: the Chebyshev distance, in bricks, to the nearest brick in which something may
/// be visible; 0 in such a brick, at most 255. Order as in BrickGrid.
struct BrickDistances {
  std::vector<std::uint8_t> distance;
  std::size_t occupied = 0;  ///< Bricks at distance 0.
};
/// hidden: the result of hidden_bricks().
BrickDistances brick_distances(const BrickGrid& bricks, std::vector<std::uint8_t> hidden);
BrickDistances brick_distances(const BrickGrid& bricks, const TransferTable& table,
                               int threads = 0);

/// For every brick: the Chebyshev distance to the nearest hidden brick, at most 255, that is, how
/// far all bricks around it are occupied; 0 for hidden bricks. hidden: 0 for bricks that are not
/// hidden.
std::vector<std::uint8_t> brick_depths(const BrickGrid& bricks,
                                       const std::vector<std::uint8_t>& hidden);

/// For every occupied brick: which of its eight parts may show something. Bit (i + 2 j + 4 k)
/// belongs to part i, j, k, each 0 or 1. Hidden bricks have all bits set. parts: of the same
/// volume.
std::vector<std::uint8_t> visible_parts(const BrickGrid& parts, const BrickGrid& bricks,
                                        const std::vector<std::uint8_t>& hidden,
                                        const TransferTable& table, int threads = 0);

/// For every brick: the greatest importance of what may be visible in it, in units of 1/254 and
/// rounded up; 255 means 1. Order as in BrickGrid.
std::vector<std::uint8_t> brick_importance(const BrickGrid& bricks, const TransferTable& table,
                                           int threads = 0);

}  // namespace nav::render
