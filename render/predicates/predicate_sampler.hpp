// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "render/predicates/set.hpp"

namespace nav::render {

/// Samples of predicates in double precision; it follows the definition in predicate_scene.hpp.
/// Thread-safe. The set must outlive it.
class PredicateSampler {
 public:
  explicit PredicateSampler(const PredicateSet& set) : set_(set) {}

  /// Value of a channel at an index, clamped to the box of voxel centres; NaN: undefined.
  [[nodiscard]] double value(std::size_t channel, const Eigen::Vector3d& index) const;
  /// Bits of the leaves that are true at an index.
  [[nodiscard]] std::uint32_t leaves(const Eigen::Vector3d& index) const;
  /// Bits of the entries that are true at an index.
  [[nodiscard]] std::uint32_t mask(const Eigen::Vector3d& index) const {
    return set_.mask_of(leaves(index));
  }

 private:
  const PredicateSet& set_;
};

/// For each entry, the number of the given voxels for which it is true: N+ or N- of the scribbles
/// (§4.1). Voxels are offsets, i fastest. An offset outside the volume is a Bug.
std::vector<std::uint64_t> count_true(const PredicateSet& set, std::span<const std::size_t> voxels);

/// Tells how much the most important entry (the first of equals) counts when other entries are true
/// too.
struct SharedImportance {
  std::size_t entry = 0;
  double share = 0;  ///< Share of the samples with this entry true for which it counts less than
                     ///< fully.
  double importance = 1;  ///< Mean importance of these samples, as a share of the entry's own
                          ///< importance.
};
/// Evaluates up to 20 000 voxels spread over the volume, always the same ones.
SharedImportance shared_importance(const PredicateSet& set);

/// Tabulated opacity of intensities: see PredicateScene.
class IntensityOpacity {
 public:
  explicit IntensityOpacity(double opacity_length_mm);
  /// Extinction of an intensity in [0, 1], per mm.
  [[nodiscard]] double tau(double intensity) const;
  /// The kTauEntries table entries.
  [[nodiscard]] const std::vector<float>& entries() const { return tau_; }

 private:
  std::vector<float> tau_;
};

}  // namespace nav::render
