// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "render/skipping/brick_grid.hpp"

namespace nav::render {

/// Data of every brick for the shader, four bytes each; order as in BrickGrid. Internal to render/.
///   0: distance to the nearest occupied brick, as in brick_distances().
///   1: an upper bound of the importance of what may be visible, in units of 1/254; 255 means 1.
///   2: as in visible_parts().
/// parts: of the same volume. hidden: the result of hidden_bricks().
struct BrickTexels {
  std::vector<std::uint8_t> texels;
  std::uint64_t occupied;  ///< Number of bricks at distance 0.
};
BrickTexels brick_texels(const BrickGrid& bricks, const BrickGrid& parts,
                         const std::vector<std::uint8_t>& hidden, const TransferTable& table);

/// Least and greatest HU of each brick, each + 32768: what the device reads for projections.
std::vector<std::uint16_t> brick_range_texels(const BrickGrid& bricks);

}  // namespace nav::render
