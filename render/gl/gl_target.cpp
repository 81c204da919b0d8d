// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_state.hpp"
// GLEW comes first, because every other GL header depends on it.
#include "render/gl/gl_target.hpp"
#include "render/gl/gl_uniforms.hpp"
#include "render/gl/gl_upload.hpp"

namespace nav::render {

Result<void> GlTarget::bind(int width, int height) {
  if (framebuffer_ == 0) glGenFramebuffers(1, &framebuffer_);
  if (vertex_array_ == 0) glGenVertexArrays(1, &vertex_array_);
  glActiveTexture(GL_TEXTURE0 + kTarget);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  if (width != width_ || height != height_) {
    gl::attach(texture_, GL_COLOR_ATTACHMENT0, GL_RGBA32F, width, height);
    if (auto ok = gl::complete_framebuffer(); !ok) return ok;
    width_ = width;
    height_ = height;
  }
  write_everything();
  glViewport(0, 0, width, height);
  return {};
}

void GlTarget::draw() const {
  glBindVertexArray(vertex_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlTarget::release() {
  texture_.release();
  if (framebuffer_ != 0) glDeleteFramebuffers(1, &framebuffer_);
  if (vertex_array_ != 0) glDeleteVertexArrays(1, &vertex_array_);
  framebuffer_ = vertex_array_ = 0;
  width_ = height_ = 0;
}

}  // namespace nav::render
