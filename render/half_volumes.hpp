// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "render/predicates/set.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// A picture may wait for so much to be sent to a device or copied in memory: some 5 to 20 ms. More
/// is done in parts of this, each with a picture of every second voxel.
inline constexpr std::size_t kBytesAPicture = std::size_t{16} << 20U;

/// The grid of every second voxel along each axis, from the first one on. Axes of fewer than 16
/// voxels keep all. An axis ends a voxel early where only the smaller grid's size would be a power
/// of two: Mesa's software rasteriser would compile anew for its textures.
VoxelGrid half_grid(const VoxelGrid& grid);

/// Scenes by predicates with every second voxel of what their sets read: an eighth of the bytes.
/// Voxels, not means: predicates are as often true of them as of the volume. What was made is kept
/// as long as scenes offer what it was made of. Internal to render/.
class HalfVolumes {
 public:
  /// The scene, which is drawn by predicates, with the set that was made of it. The same step in
  /// voxels, so the cells are twice as long.
  Scene of(const Scene& scene, const PredicateSet& set);
  void release();

 private:
  struct HalfLabels {
    LabelVolume of;
    LabelVolume half;
  };
  struct HalfFeature {
    FeatureVolume of;
    FeatureVolume half;
  };

  void halve_features(const PredicateSet& set, Features& offered);
  void halve_labels(const PredicateSet& set, Features& offered);

  std::shared_ptr<const Volume> volume_;
  std::shared_ptr<const Volume> half_;
  std::map<const Volume*, HalfFeature> features_;  ///< By their codes.
  std::optional<HalfLabels> labels_;
};

}  // namespace nav::render
