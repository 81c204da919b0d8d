// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "render/predicates/set.hpp"

namespace nav::render {

/// Samples of predicates in double precision: the definition of predicate_scene.hpp. Thread-safe.
/// The set must outlive it.
class PredicateSampler {
 public:
  explicit PredicateSampler(const PredicateSet& set) : set_(set) {}

  /// Of a channel at an index, clamped to the box of voxel centres; NaN: undefined.
  [[nodiscard]] double value(std::size_t channel, const Eigen::Vector3d& index) const;
  /// Which leaves are true there.
  [[nodiscard]] std::uint32_t leaves(const Eigen::Vector3d& index) const;
  /// Which entries are true there.
  [[nodiscard]] std::uint32_t mask(const Eigen::Vector3d& index) const {
    return set_.mask_of(leaves(index));
  }

 private:
  const PredicateSet& set_;
};

/// For how many of some voxels each entry is true: N+ or N- of the scribbles (§4.1). Voxels are
/// offsets, i fastest; refuses none: out of the volume is a Bug.
std::vector<std::uint64_t> count_true(const PredicateSet& set, std::span<const std::size_t> voxels);

/// How the most important entry, the first of equals, fares where others are true as well.
struct SharedImportance {
  std::size_t entry = 0;
  double share = 0;  ///< Of the places where it is true: those where it counts less than fully.
  double importance = 1;  ///< Mean there, as a share of what it has alone.
};
/// Of some ten thousand voxels spread over the volume, the same ones each time.
SharedImportance shared_importance(const PredicateSet& set);

/// The opacity of intensities, tabulated: see PredicateScene.
class IntensityOpacity {
 public:
  explicit IntensityOpacity(double opacity_length_mm);
  /// Extinction, per mm, of an intensity in [0, 1].
  [[nodiscard]] double tau(double intensity) const;
  /// kTauEntries of them.
  [[nodiscard]] const std::vector<float>& entries() const { return tau_; }

 private:
  std::vector<float> tau_;
};

}  // namespace nav::render
