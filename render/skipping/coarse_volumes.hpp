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
/// is done in parts of this, each with a picture of CoarseVolumes.
inline constexpr std::size_t kBytesAPicture = std::size_t{16} << 20U;

/// The grid of every second voxel along each axis, from the first one on; of every fourth along
/// axes of more than 384, and of all along those of fewer than 16. An axis ends a voxel early where
/// only the smaller grid's size would be a power of two: Mesa's software rasteriser would compile
/// anew for its textures.
VoxelGrid coarse_grid(const VoxelGrid& grid);

/// Scenes by predicates with the voxels of coarse_grid() of what their sets read: an eighth of the
/// bytes, a 64th of those of large volumes. Voxels, not means: predicates are as often true of them
/// as of the volume. What was made is kept as long as scenes offer what it was made of. Internal to
/// render/.
class CoarseVolumes {
 public:
  /// The scene, which is drawn by predicates, with the set that was made of it. The same step in
  /// voxels, so the cells are two or four times as long.
  Scene of(const Scene& scene, const PredicateSet& set);
  void release();

 private:
  struct CoarseLabels {
    LabelVolume of;
    LabelVolume coarse;
  };
  struct CoarseFeature {
    FeatureVolume of;
    FeatureVolume coarse;
  };

  void coarsen_features(const PredicateSet& set, Features& offered);
  void coarsen_labels(const PredicateSet& set, Features& offered);

  std::shared_ptr<const Volume> volume_;
  std::shared_ptr<const Volume> coarse_;
  std::map<const Volume*, CoarseFeature> features_;  ///< By their codes.
  std::optional<CoarseLabels> labels_;
};

}  // namespace nav::render
