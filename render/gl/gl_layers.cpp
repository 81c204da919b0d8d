// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <array>

#include "render/gl/gl_layers.hpp"
#include "render/gl/gl_upload.hpp"

namespace nav::render {

void GlLayers::attach(int width, int height, bool plane, bool signatures) {
  gl::attach(front, GL_COLOR_ATTACHMENT0, GL_RGBA32F, width, height);
  gl::attach(spent, GL_COLOR_ATTACHMENT1, GL_RGBA32F, width, height);
  if (plane) {
    gl::attach(behind, GL_COLOR_ATTACHMENT2, GL_RGBA32F, width, height);
    gl::attach(live_at, GL_COLOR_ATTACHMENT3, GL_RG32F, width, height);
  } else {
    // A texture that stays attached, even a smaller one, limits everything that is drawn.
    for (const GLenum unused : {GL_COLOR_ATTACHMENT2, GL_COLOR_ATTACHMENT3}) {
      glFramebufferTexture2D(GL_FRAMEBUFFER, unused, GL_TEXTURE_2D, 0, 0);
    }
  }
  const auto with = [](bool used, GLenum attachment) { return used ? attachment : GL_NONE; };
  const std::array<GLenum, 5> all{
      GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, with(plane, GL_COLOR_ATTACHMENT2),
      with(plane, GL_COLOR_ATTACHMENT3), with(signatures, GL_COLOR_ATTACHMENT4)};
  glDrawBuffers(static_cast<GLsizei>(all.size()), all.data());
}

void GlLayers::release() {
  for (GlTexture* texture : {&front, &spent, &behind, &live_at}) texture->release();
}

}  // namespace nav::render
