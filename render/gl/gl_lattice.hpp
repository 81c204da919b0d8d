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

/// The passes of sparse_rays.hpp on OpenGL. Each takes over what it may, and casts rays where that
/// has left the depth of the target far. Every function needs the context current. Internal to
/// render/.
class GlLattice {
 public:
  GlLattice() = default;
  ~GlLattice() { release(); }
  GlLattice(const GlLattice&) = delete;
  GlLattice& operator=(const GlLattice&) = delete;

  /// Targets for a picture of that many pixels, which a framebuffer holds. layers: with what lies
  /// behind the ultrasound picture. Leaves another framebuffer bound.
  Result<void> prepare(int width, int height, bool layers, unsigned framebuffer,
                       const SparseRays& sparse);
  /// Draws the picture. rays: of raycast.frag; means: of sparse_means.frag; both set up.
  void draw(GlProgram& rays, GlProgram& means, const std::function<void()>& draw_triangle);
  void release();

 private:
  /// What one pass draws.
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

  std::array<Level, 2> levels_;  ///< Of strides 4 and 2.
  Level last_;                   ///< The picture: of it only the depth is ours.
  SparseRays sparse_{2, 0};
  bool layers_ = false;
};

}  // namespace nav::render
