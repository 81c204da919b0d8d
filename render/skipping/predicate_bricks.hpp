// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/predicates/set.hpp"
#include "render/skipping/brick_grid.hpp"

namespace nav::render {

/// Ranges of one channel in every brick, in codes. Order and apron as in BrickGrid.
struct ChannelBricks {
  BrickGrid range;                      ///< Range of the defined voxels; low > high: none.
  std::vector<std::uint8_t> undefined;  ///< 1: some voxel is undefined; empty: no brick has any.
};
ChannelBricks channel_bricks(const PredicateSet::Channel& channel, int threads);

/// Labels of every brick: the bits of any voxel, and the bits of all voxels.
struct LabelBricks {
  std::vector<std::uint32_t> any;
  std::vector<std::uint32_t> all;
};
LabelBricks label_bricks(const LabelVolume& labels, int threads);

/// Truth of the leaves of a predicate set in every brick.
struct LeafBricks {
  std::vector<std::int32_t> sure;  ///< Bits of leaves that are true for all samples.
  std::vector<std::int32_t> open;  ///< Bits of leaves that are not decided.
  std::vector<std::uint8_t> dark;  ///< 1: no sample has any intensity.
};
/// Classifies the leaves in every brick. channels: one for each channel of the set. labels: null if
/// the set needs none. Ranges are widened by the rounding of single precision, so that a leaf that
/// is decided here is decided there too.
LeafBricks leaf_bricks(const PredicateSet& set, const std::vector<const ChannelBricks*>& channels,
                       const LabelBricks* labels, int threads);

/// The greatest importance in every brick; 0: nothing is visible.
std::vector<double> brick_importances(const PredicateSet& set, const LeafBricks& leaves,
                                      int threads);

}  // namespace nav::render
