// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>

#include "nav/result.hpp"
#include "render/gl/gl_layers.hpp"
#include "render/gl/gl_program.hpp"
#include "render/quality/sparse_rays.hpp"

namespace nav::render {

/// The passes of sparse_rays.hpp on OpenGL. Each pass first interpolates the pixels that allow it,
/// and then casts rays where the depth of the target is still far. Every function needs the context
/// current. Internal to render/.
class GlLattice {
 public:
  GlLattice() = default;
  ~GlLattice() { release(); }
  GlLattice(const GlLattice&) = delete;
  GlLattice& operator=(const GlLattice&) = delete;

  /// Makes targets for an image of this size, which framebuffer holds. layers: includes what lies
  /// behind the ultrasound image. Leaves another framebuffer bound.
  Result<void> prepare(int width, int height, bool layers, unsigned framebuffer,
                       const SparseRays& sparse);
  /// Draws the image. rays: program of raycast.frag; means: program of sparse_means.frag; both with
  /// their uniforms set. \p draw_rows fills the viewport, which has this many rows.
  void draw(GlProgram& rays, GlProgram& means, const std::function<void(int)>& draw_rows);
  void release();

 private:
  /// The targets of one pass.
  struct Level {
    GlLayers layers;
    unsigned depth = 0;
    unsigned framebuffer = 0;
    int width = 0;
    int height = 0;
  };
  Result<void> add_targets(Level& level) const;
  static void add_depth(Level& level);
  static void bind(Level& level);

  std::array<Level, 2> levels_;  ///< Strides 4 and 2.
  Level last_;                   ///< The image itself. Only its depth belongs to this class.
  SparseRays sparse_{2, 0};
  bool layers_ = false;
};

}  // namespace nav::render
