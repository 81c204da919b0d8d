// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "render/gl/gl_program.hpp"
#include "render/gl/gl_textures.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// Depth of opaque geometry that somebody else has drawn with the same camera.
struct SharedDepth {
  unsigned texture;      ///< Depth texture of the picture's size.
  Eigen::Vector4d rows;  ///< Elements (2,2) (2,3) (3,2) (3,3) of clip_from_view.
};

/// Texture units, above those that VTK hands out itself.
enum GlUnit {
  kCt = 20,
  kGradients,
  kTransfer,
  kImportances,
  kIntegrals,
  kBricks,
  kBrickCells,
  kPicture,
  kSolids,
  kCutObjects,
  kCutField,
  kDepth,
  kSecondVolume,
  kFront,
  kBehind,
  kSignatures,
  kSpent = kSignatures,  ///< Rays that are spared have no signatures.
  kLiveAt,
  kFeatures,  ///< And the two after it.
  kUndefined = kFeatures + 3,
  kLabels,
  kPredicateBricks,
  kLooks,
  kLeaves,
  kOpacity,
  kTarget,
  kRayList = kLooks  ///< Rays that are spared are none by predicates.
};

/// What a scene needs compiled in. A plane or needle that is lost needs nothing. textures: updated
/// for the scene.
GlFeatures features_of(const Scene& scene, const GlTextures& textures, bool shared_depth,
                       bool manual_filter);

/// What shaders/sparse_means.frag needs of a scene; the passes come from GlLattice.
GlFeatures means_features(const GlFeatures& features);
void set_means_uniforms(GlProgram& program, const GlFeatures& features, const Scene& scene,
                        const GlTextures& textures, const std::optional<SharedDepth>& depth);

/// What shaders/include/camera.glsl, ct.glsl and lattice.glsl need.
void set_rays(GlProgram& program, const Scene& scene);

/// Names of a second volume, as in shaders/include/second_names.glsl, are those of one volume after
/// this.
inline constexpr const char* kSecond = "second_";

/// What shaders/include/bricks.glsl needs: bricks in a texture unit. prefix: of the names.
/// farthest_mm: of the volume from where t is counted from, when that is not in front of it.
void set_brick_walk(GlProgram& program, const VoxelGrid& grid, const Eigen::Vector3i& brick_count,
                    int unit, const std::string& prefix = {}, double farthest_mm = 0);

/// How far two volumes reach from each other at most, mm; 0 with one.
double reach_mm(const Scene& scene);

/// The alpha at which a ray ends; more than 1: never.
double opaque_at(const Scene& scene);

/// Sets every uniform of the program in use but those of predicates; geometry is prepared in
/// double. depth: given exactly when features.shared_depth.
void set_uniforms(GlProgram& program, const GlFeatures& features, const Scene& scene,
                  const GlTextures& textures, const std::optional<SharedDepth>& depth);

}  // namespace nav::render
