// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "render/skipping/predicate_bricks.hpp"

namespace nav::render {

/// What is known of the bricks of a volume for the set that is drawn. Ranges of channels stay as
/// long as anything holds their voxels, those of labels while they are asked for; leaves are
/// classified anew when one of them is another.
class PredicateBrickCache {
 public:
  /// Whether leaves are classified for that set already.
  [[nodiscard]] bool knows(const PredicateSet& set) const;
  /// True: leaves were classified anew. threads: 0: all cores.
  bool update(const PredicateSet& set, int threads);
  /// Channels of a set whose ranges update() would have to find first.
  [[nodiscard]] std::size_t missing_channels(const PredicateSet& set) const;
  /// Finds the ranges of one of them beforehand; false: there is none.
  bool prepare_channel(const PredicateSet& set, int threads);

  [[nodiscard]] const LeafBricks& leaves() const { return leaves_; }
  /// Of the volume.
  [[nodiscard]] const BrickGrid& grid() const { return channels_.at(volume_).bricks.range; }

 private:
  struct Known {
    std::weak_ptr<const Volume> codes;  ///< As long as they live, their address is their own.
    ChannelBricks bricks;
  };
  void forget_channels_of_the_past();
  [[nodiscard]] bool has_channel(const PredicateSet::Channel& channel) const;
  void take_labels(const PredicateSet& set, int threads);

  std::optional<PredicateSet> set_;
  std::map<const Volume*, Known> channels_;
  const Volume* volume_ = nullptr;
  std::optional<LabelVolume> labels_;
  std::optional<LabelBricks> label_bricks_;
  LeafBricks leaves_;
};

/// For every brick the Chebyshev distance, in bricks, to the nearest one of an importance > 0.
std::vector<std::uint8_t> visible_distances(const BrickGrid& grid,
                                            const std::vector<double>& importances);

/// What is known of a brick and of all that touch it, also at an edge or a corner.
struct KnownAround {
  double importance;   ///< The greatest.
  std::uint32_t sure;  ///< Leaves that are true in all of them.
  std::uint32_t some;  ///< Leaves that may be true in one of them.
};
std::vector<KnownAround> known_around(const Eigen::Vector3i& count,
                                      const std::vector<double>& importances,
                                      const LeafBricks& leaves);

}  // namespace nav::render
