// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "render/skipping/predicate_bricks.hpp"

namespace nav::render {

/// Knowledge about the bricks of a volume for the drawn predicate set. Ranges of channels stay as
/// long as anything holds their voxels; ranges of labels stay while they are read. Leaves are
/// classified again if one of them changes.
class PredicateBrickCache {
 public:
  /// True if the leaves are already classified for a predicate set.
  [[nodiscard]] bool knows(const PredicateSet& set) const;
  /// Classifies the leaves if needed; true: they were classified again. threads 0: all cores.
  bool update(const PredicateSet& set, int threads);
  /// Number of channels of a predicate set whose ranges update() would have to find first.
  [[nodiscard]] std::size_t missing_channels(const PredicateSet& set) const;
  /// Finds the ranges of one missing channel beforehand; false: none is missing.
  bool prepare_channel(const PredicateSet& set, int threads);

  [[nodiscard]] const LeafBricks& leaves() const { return leaves_; }
  /// The grid of the volume.
  [[nodiscard]] const BrickGrid& grid() const { return channels_.at(volume_).bricks.range; }

 private:
  struct Known {
    std::weak_ptr<const StoredVolume> codes;  ///< While they live, their address is unique.
    ChannelBricks bricks;
  };
  void forget_channels_of_the_past();
  [[nodiscard]] bool has_channel(const PredicateSet::Channel& channel) const;
  void take_labels(const PredicateSet& set, int threads);

  std::optional<PredicateSet> set_;
  std::map<const StoredVolume*, Known> channels_;
  const StoredVolume* volume_ = nullptr;
  std::optional<LabelVolume> labels_;
  std::optional<LabelBricks> label_bricks_;
  LeafBricks leaves_;
};

/// For every brick: the Chebyshev distance, in bricks, to the nearest brick with an importance > 0.
std::vector<std::uint8_t> visible_distances(const BrickGrid& grid,
                                            const std::vector<double>& importances);

/// Knowledge about a brick and all bricks that touch it, also at an edge or a corner.
struct KnownAround {
  double importance;   ///< The greatest importance of all of them.
  std::uint32_t sure;  ///< Leaves that are true in all of them.
  std::uint32_t some;  ///< Leaves that may be true in at least one of them.
};
std::vector<KnownAround> known_around(const Eigen::Vector3i& count,
                                      const std::vector<double>& importances,
                                      const LeafBricks& leaves);

}  // namespace nav::render
