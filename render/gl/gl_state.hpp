// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vtk_glew.h>

namespace nav::render {

/// Restores what a ray casting pass changes, so that VTK's record of the OpenGL state stays true.
/// Only for render/gl/*.cpp.
class GlStateGuard {
 public:
  GlStateGuard() {
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_framebuffer_);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read_framebuffer_);
    glGetIntegerv(GL_VIEWPORT, viewport_.data());
    glGetIntegerv(GL_SCISSOR_BOX, scissor_.data());
    glGetIntegerv(GL_ACTIVE_TEXTURE, &active_texture_);
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array_);
    glGetIntegerv(GL_CURRENT_PROGRAM, &program_);
    glGetIntegerv(GL_BLEND_SRC_RGB, &blend_[0]);
    glGetIntegerv(GL_BLEND_DST_RGB, &blend_[1]);
    glGetIntegerv(GL_BLEND_SRC_ALPHA, &blend_[2]);
    glGetIntegerv(GL_BLEND_DST_ALPHA, &blend_[3]);
    glGetBooleanv(GL_COLOR_WRITEMASK, colour_mask_.data());
    glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
    glGetIntegerv(GL_DEPTH_FUNC, &depth_function_);
    for (std::size_t i = 0; i < kSwitches.size(); ++i) switches_[i] = glIsEnabled(kSwitches[i]);
  }
  ~GlStateGuard() {
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_framebuffer_));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read_framebuffer_));
    glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    glScissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
    glActiveTexture(static_cast<GLenum>(active_texture_));
    glBindVertexArray(static_cast<GLuint>(vertex_array_));
    glUseProgram(static_cast<GLuint>(program_));
    glBlendFuncSeparate(static_cast<GLenum>(blend_[0]), static_cast<GLenum>(blend_[1]),
                        static_cast<GLenum>(blend_[2]), static_cast<GLenum>(blend_[3]));
    glColorMask(colour_mask_[0], colour_mask_[1], colour_mask_[2], colour_mask_[3]);
    glDepthMask(depth_mask_);
    glDepthFunc(static_cast<GLenum>(depth_function_));
    for (std::size_t i = 0; i < kSwitches.size(); ++i) {
      if (switches_[i]) {
        glEnable(kSwitches[i]);
      } else {
        glDisable(kSwitches[i]);
      }
    }
  }
  GlStateGuard(const GlStateGuard&) = delete;
  GlStateGuard& operator=(const GlStateGuard&) = delete;

 private:
  static constexpr std::array<GLenum, 5> kSwitches{GL_BLEND, GL_DEPTH_TEST, GL_CULL_FACE,
                                                   GL_SCISSOR_TEST, GL_MULTISAMPLE};
  GLint draw_framebuffer_ = 0, read_framebuffer_ = 0, active_texture_ = 0, vertex_array_ = 0;
  GLint program_ = 0, depth_function_ = GL_LESS;
  std::array<GLint, 4> viewport_{}, scissor_{}, blend_{};
  std::array<GLboolean, 4> colour_mask_{};
  GLboolean depth_mask_ = GL_TRUE;
  std::array<GLboolean, 5> switches_{};
};

/// Sets up a pass that writes every pixel: no test, no blending, no depth. Call it under a
/// GlStateGuard.
inline void write_everything() {
  for (const GLenum test : {GL_BLEND, GL_DEPTH_TEST, GL_CULL_FACE, GL_SCISSOR_TEST}) {
    glDisable(test);
  }
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_FALSE);
}

/// Sets up a pass that writes the depth of every pixel. After keep_nearer() the next pass draws
/// only where that depth is farther.
inline void write_depth() {
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_ALWAYS);
  glDepthMask(GL_TRUE);
}
inline void keep_nearer() {
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_FALSE);
}

}  // namespace nav::render
