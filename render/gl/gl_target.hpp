// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "render/gl/gl_textures.hpp"

namespace nav::render {

/// A picture of four floats a pixel that a program fills beside those of a scene. Needs the context
/// current, also to be released; changes the state that a GlStateGuard restores. Internal to
/// render/.
class GlTarget {
 public:
  GlTarget() = default;
  ~GlTarget() { release(); }
  GlTarget(const GlTarget&) = delete;
  GlTarget& operator=(const GlTarget&) = delete;

  /// Binds its framebuffer, of that many pixels, all of which what follows writes. Error: one that
  /// the device does not draw to.
  Result<void> bind(int width, int height);
  /// One triangle over all of them, by the program in use.
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
