// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include "render/gl/gl_lattice.hpp"
#include "render/gl/gl_state.hpp"
#include "render/gl/gl_uniforms.hpp"
#include "render/gl/gl_upload.hpp"

namespace nav::render {

Result<void> GlLattice::prepare(int width, int height, bool layers, unsigned framebuffer,
                                const SparseRays& sparse) {
  sparse_ = sparse;
  if (framebuffer == last_.framebuffer && width == last_.width && height == last_.height &&
      layers == layers_) {
    return {};
  }
  release();
  layers_ = layers;
  glActiveTexture(GL_TEXTURE0 + kTarget);
  for (int stride = 4; Level & level : levels_) {
    level.width = (width + stride - 1) / stride;
    level.height = (height + stride - 1) / stride;
    stride /= 2;
    if (auto ok = add_targets(level); !ok) return ok;
  }
  last_.width = width;
  last_.height = height;
  last_.framebuffer = framebuffer;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  add_depth(last_);
  return gl::complete_framebuffer();
}

Result<void> GlLattice::add_targets(Level& level) const {
  glGenFramebuffers(1, &level.framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, level.framebuffer);
  level.layers.attach(level.width, level.height, layers_, false);
  add_depth(level);
  return gl::complete_framebuffer();
}

/// Adds depth to the framebuffer that is bound.
void GlLattice::add_depth(Level& level) {
  glGenRenderbuffers(1, &level.depth);
  glBindRenderbuffer(GL_RENDERBUFFER, level.depth);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, level.width, level.height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, level.depth);
  glBindRenderbuffer(GL_RENDERBUFFER, 0);
}

void GlLattice::bind(Level& level) {
  for (const auto& [unit, texture] :
       {std::pair{kFront, &level.layers.front}, std::pair{kSpent, &level.layers.spent},
        std::pair{kBehind, &level.layers.behind}, std::pair{kLiveAt, &level.layers.live_at}}) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(GL_TEXTURE_2D, texture->id());
  }
}

void GlLattice::draw(GlProgram& rays, GlProgram& means, const std::function<void(int)>& draw_rows) {
  const PixelLattice lattice(last_.width, last_.height, sparse_.stride);
  means.use();
  means.set("pixel_error", static_cast<double>(sparse_.error));
  means.set("last_of_lattice", Eigen::Vector2i(lattice.last_x, lattice.last_y));
  Level* before = nullptr;
  for (int step = lattice.stride; step > 0; step /= 2) {
    Level& level = step == 1 ? last_ : levels_[step == 4 ? 0 : 1];
    glBindFramebuffer(GL_FRAMEBUFFER, level.framebuffer);
    glViewport(0, 0, level.width, level.height);
    if (before != nullptr) {
      bind(*before);
      means.use();
      means.set("pixel_step", step);
      means.set("coarse_step", 2 * step);
      write_depth();
      draw_rows(level.height);
      keep_nearer();
    }
    rays.use();
    rays.set("pixel_step", step);
    draw_rows(level.height);
    before = &level;
  }
  write_everything();
}

void GlLattice::release() {
  for (Level* level : {&levels_[0], &levels_[1], &last_}) {
    level->layers.release();
    if (level->depth != 0) glDeleteRenderbuffers(1, &level->depth);
    if (level != &last_ && level->framebuffer != 0) glDeleteFramebuffers(1, &level->framebuffer);
    level->depth = level->framebuffer = 0;
  }
}

}  // namespace nav::render
