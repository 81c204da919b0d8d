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

/// The depth of opaque geometry that others have drawn with the same camera.
struct SharedDepth {
  unsigned texture;      ///< Depth texture of the image's size.
  Eigen::Vector4d rows;  ///< Elements (2,2) (2,3) (3,2) (3,3) of clip_from_view.
};

/// Texture units above those that VTK assigns itself.
enum GlUnit {
  kCt = 20,
  kGradients,
  kTransfer,
  kImportances,
  kIntegrals,
  kBricks,
  kImage,
  kSolids,
  kCutObjects,
  kCutField,
  kDepth,
  kSecondVolume,
  kFront,
  kBehind,
  kSignatures,
  kSpent = kSignatures,  ///< Sparse rays have no signatures.
  kLiveAt,
  kFeatures,  ///< Also the next two units.
  kUndefined = kFeatures + 3,
  kLabels,
  kPredicateBricks,
  kAppearances,
  kLeaves,
  kOpacity,
  kPredicateGradients,
  kTarget
};

/// The parts of a scene that must be compiled in. A lost plane or needle needs nothing. textures:
/// updated for the scene.
GlFeatures features_of(const Scene& scene, const GlTextures& textures, bool shared_depth,
                       bool manual_filter);

/// The features of shaders/sparse_means.frag for a scene with these features, and its uniforms.
/// GlLattice provides the passes.
GlFeatures means_features(const GlFeatures& features);
void set_means_uniforms(GlProgram& program, const GlFeatures& features, const Scene& scene,
                        const GlTextures& textures, const std::optional<SharedDepth>& depth);

/// Sets the uniforms of shaders/include/camera.glsl, ct.glsl and lattice.glsl.
void set_rays(GlProgram& program, const Scene& scene);

/// Prefix of the names of a second volume, as in shaders/include/second_names.glsl: without it they
/// are the names of one volume.
inline constexpr const char* kSecond = "second_";

/// Sets the uniforms of shaders/include/bricks.glsl. unit: texture unit of the bricks. prefix: of
/// the names. farthest_mm: distance of the volume from the position from which t is counted, if
/// that position is not in front of it.
void set_brick_walk(GlProgram& program, const VoxelGrid& grid, const Eigen::Vector3i& brick_count,
                    int unit, const std::string& prefix = {}, double farthest_mm = 0);

/// The greatest distance between positions in two volumes, mm; 0 if there is only one volume.
double reach_mm(const Scene& scene);

/// The alpha at which a ray ends; more than 1: never.
double opaque_at(const Scene& scene);

/// Sets every uniform of the program in use, except those of predicates. Geometry is prepared in
/// double. depth: present exactly if features.shared_depth.
void set_uniforms(GlProgram& program, const GlFeatures& features, const Scene& scene,
                  const GlTextures& textures, const std::optional<SharedDepth>& depth);

}  // namespace nav::render
