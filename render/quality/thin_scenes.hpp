// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "render/scene.hpp"

namespace nav::render {

/// Every second voxel along each axis of at least 16 voxels, from the first one on: an eighth of
/// the bytes. Each takes the mean of itself and of the voxels around it within 150 HU, which are of
/// the same material: a value may stand for a material (bone that was taken out of vessels), and a
/// mean of two materials is a third one.
std::shared_ptr<const StoredVolume> every_second_voxel(const StoredVolume& volume);

/// Makes scenes of every second voxel of the CT for images with few pixels. Their rays are far
/// apart, so that each reads voxels of its own from memory, and a full-sized CT does not fit into
/// the caches of a processor. Keeps the volumes of the last scene.
class ThinScenes {
 public:
  /// The scene with the thinner CT and gradients, and with steps of at least 0.95 of its voxels.
  /// None: the scene shows predicates, whose speckle would be another.
  [[nodiscard]] std::optional<Scene> of(const Scene& scene);

 private:
  struct Thin {
    std::shared_ptr<const StoredVolume> whole;  ///< Held so that no other volume gets its address.
    std::shared_ptr<const StoredVolume> thin;
  };
  static void thin_out(const std::shared_ptr<const StoredVolume>& whole, Thin& kept);

  Thin ct_;
  Thin gradients_;
};

}  // namespace nav::render
