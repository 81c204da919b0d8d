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

/// Voxels along one edge of a brick; what a leap cannot see inside of.
inline constexpr int kBrickVoxels = 8;

/// Voxels along one edge of a part, an eighth of a brick.
inline constexpr int kPartVoxels = kBrickVoxels / 2;

/// Bytes past the last brick's in a table of one byte per brick: a byte is fetched as the first of
/// four.
inline constexpr std::size_t kBrickTail = 3;

/// Least and greatest HU of every brick of a volume. Brick b holds the trilinear samples whose
/// lower voxel is in [8b, 8b + 8) along each axis, so its range includes one voxel beyond (the
/// apron). Order: i fastest. Shared by the engines that leap over empty bricks. The same for parts,
/// with 4 for 8.
struct BrickGrid {
  Eigen::Vector3i count = Eigen::Vector3i::Zero();  ///< Bricks along i, j, k: (n - 1) / 8 + 1.
  std::vector<std::int16_t> low;
  std::vector<std::int16_t> high;
};
/// Uses at most threads threads; 0: all cores.
BrickGrid make_brick_grid(const Volume& volume, int threads);
/// The same of parts.
BrickGrid make_part_grid(const Volume& volume, int threads);

/// Bricks [from, to) of a row.
struct BrickSpan {
  int from;
  int to;
};
/// From the first occupied brick of a row to the last one: those that are 0; else from = to.
BrickSpan occupied_span(const std::uint8_t* row, int count);

/// 0 for every brick where something may be visible, 255 for the others: the ones that are hidden.
/// Order as in BrickGrid.
std::vector<std::uint8_t> hidden_bricks(const BrickGrid& bricks, const TransferTable& table,
                                        int threads = 0);

/// For every brick the Chebyshev distance, in bricks, to the nearest one where something may be
/// visible: 0 there, at most 255. Order as in BrickGrid.
struct BrickDistances {
  std::vector<std::uint8_t> distance;
  std::size_t occupied = 0;  ///< Bricks at distance 0.
};
/// hidden: as hidden_bricks().
BrickDistances brick_distances(const BrickGrid& bricks, std::vector<std::uint8_t> hidden);
BrickDistances brick_distances(const BrickGrid& bricks, const TransferTable& table,
                               int threads = 0);

/// For every brick that is not hidden the Chebyshev distance to the nearest one that is, 0 for
/// those that are, at most 255: how far all is occupied around. hidden: 0 for those that are not.
std::vector<std::uint8_t> brick_depths(const BrickGrid& bricks,
                                       const std::vector<std::uint8_t>& hidden);

/// Which of the eight parts of every occupied brick may show something, bit (i + 2 j + 4 k) for
/// the part i, j, k of it, each 0 or 1; all bits of the hidden ones. Parts: of the same volume.
std::vector<std::uint8_t> visible_parts(const BrickGrid& parts, const BrickGrid& bricks,
                                        const std::vector<std::uint8_t>& hidden,
                                        const TransferTable& table, int threads = 0);

/// For every brick the greatest importance of what may be visible in it, in parts of 254 and
/// rounded up; 255: 1. Order as in BrickGrid.
std::vector<std::uint8_t> brick_importance(const BrickGrid& bricks, const TransferTable& table,
                                           int threads = 0);

}  // namespace nav::render
