// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "render/predicates/set.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// Bytes that an image may wait for while they are sent to a device or copied in memory: about 5 to
/// 20 ms. Larger work is done in parts of this size, and each part shows an image of CoarseVolumes.
inline constexpr std::size_t kBytesAImage = std::size_t{16} << 20U;

/// The grid of every second voxel along each axis, from the first one on. Axes of more than 384
/// voxels keep every fourth voxel, and axes of fewer than 16 keep all. An axis ends one voxel early
/// if only the coarse size would be a power of two: Mesa's software rasteriser would compile anew
/// for its textures.
VoxelGrid coarse_grid(const VoxelGrid& grid);

/// Makes scenes by predicates with the voxels of coarse_grid() of everything that their predicate
/// sets read: an eighth of the bytes, a 64th for large volumes. It keeps voxels instead of means,
/// so that predicates are true for them as often as for the volume. Results are kept as long as
/// scenes offer their originals. Internal to render/.
class CoarseVolumes {
 public:
  /// The coarse scene. scene: is drawn by predicates. set: the predicate set made from it. The step
  /// in voxels stays the same, so cells are two or four times as long.
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
  void coarsen_gradients(std::optional<PredicateShading>& shading);

  std::shared_ptr<const StoredVolume> volume_;
  std::shared_ptr<const StoredVolume> coarse_;
  std::map<const StoredVolume*, CoarseFeature> features_;  ///< Keyed by their codes.
  std::optional<CoarseLabels> labels_;
  std::shared_ptr<const StoredVolume> gradients_;  ///< PredicateShading::source.
  std::shared_ptr<const StoredVolume> coarse_gradients_;
};

}  // namespace nav::render
