// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>
#include <vtk_glew.h>

/// Drawing by compute shaders. Only for render/gl/*.cpp.
namespace nav::render::gl {

/// Binds the textures that a compute shader writes, by image unit; 0: none.
class ImageTargets {
 public:
  struct Target {
    GLuint texture;
    GLenum format;
  };
  explicit ImageTargets(const std::vector<Target>& targets)
      : count_(static_cast<GLuint>(targets.size())) {
    for (GLuint unit = 0; unit < count_; ++unit) {
      const auto& [texture, format] = targets[unit];
      glBindImageTexture(unit, texture, 0, GL_FALSE, 0, GL_WRITE_ONLY, format);
    }
  }
  ~ImageTargets() {
    for (GLuint unit = 0; unit < count_; ++unit)
      glBindImageTexture(unit, 0, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  }
  ImageTargets(const ImageTargets&) = delete;
  ImageTargets& operator=(const ImageTargets&) = delete;

 private:
  GLuint count_;
};

/// Runs the program in use for every pixel. The next reader of its targets finds them written.
inline void dispatch(int width, int height) {
  constexpr int kGroup = 8;  // Same as in shaders/include/targets.glsl.
  const auto groups = [](int n) { return static_cast<GLuint>((n + kGroup - 1) / kGroup); };
  glDispatchCompute(groups(width), groups(height), 1);
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                  GL_FRAMEBUFFER_BARRIER_BIT | GL_PIXEL_BUFFER_BARRIER_BIT |
                  GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

}  // namespace nav::render::gl
