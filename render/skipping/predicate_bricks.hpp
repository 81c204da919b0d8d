// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/predicates/set.hpp"
#include "render/skipping/brick_grid.hpp"

namespace nav::render {

/// Ranges of one channel in every brick, in codes. Order as in BrickGrid, with its apron.
struct ChannelBricks {
  BrickGrid range;                      ///< Of the voxels that have a value; low > high: none has.
  std::vector<std::uint8_t> undefined;  ///< Some voxel has no value; empty: nowhere.
};
ChannelBricks channel_bricks(const PredicateSet::Channel& channel, int threads);

/// Labels of every brick: bits of any voxel, and of all.
struct LabelBricks {
  std::vector<std::uint32_t> any;
  std::vector<std::uint32_t> all;
};
LabelBricks label_bricks(const LabelVolume& labels, int threads);

/// What is known of the leaves of a set in every brick.
struct LeafBricks {
  std::vector<std::int32_t> sure;  ///< Bits of leaves that are true for all samples.
  std::vector<std::int32_t> open;  ///< Bits of leaves that are not decided.
  std::vector<std::uint8_t> dark;  ///< No sample has any intensity.
};
/// channels: one for each of the set's; labels: null where the set needs none. Ranges are widened
/// by what single precision may round, so that a decided leaf is decided there too.
LeafBricks leaf_bricks(const PredicateSet& set, const std::vector<const ChannelBricks*>& channels,
                       const LabelBricks* labels, int threads);

/// The greatest importance of every brick; 0: nothing is visible.
std::vector<double> brick_importances(const PredicateSet& set, const LeafBricks& leaves,
                                      int threads);

}  // namespace nav::render
