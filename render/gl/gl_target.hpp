// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "render/gl/gl_textures.hpp"

namespace nav::render {

/// An image of four floats per pixel that a program fills, apart from the images of a scene. Needs
/// the context current, also for release(); changes the state that a GlStateGuard restores.
/// Internal to render/.
class GlTarget {
 public:
  GlTarget() = default;
  ~GlTarget() { release(); }
  GlTarget(const GlTarget&) = delete;
  GlTarget& operator=(const GlTarget&) = delete;

  /// Binds its framebuffer with this size; the next pass must write all of its pixels. Errors: the
  /// device cannot draw to it.
  Result<void> bind(int width, int height);
  /// Draws one triangle over all pixels by the program in use.
  void draw() const;
  unsigned texture() { return texture_.id(); }
  void release();

 private:
  GlTexture texture_;
  unsigned framebuffer_ = 0;
  unsigned vertex_array_ = 0;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace nav::render
