// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "render/engine.hpp"
#include "render/gl/gl_program.hpp"
#include "render/gl/gl_read.hpp"
#include "render/gl/gl_target.hpp"

namespace nav::render {

/// Counts the cost of an image's rays from the texture to which they have written it
/// (shaders/include/lattice.glsl). Needs the context current, also for release(). Internal to
/// render/.
class GlCostSums {
 public:
  /// The second attachment of a framebuffer to which an image of this size has been drawn.
  struct Source {
    unsigned framebuffer;
    unsigned texture;
    int width;
    int height;
  };
  /// Adds samples, gradients, faded cells and rays. in_software: every pixel is read and summed
  /// here; otherwise the device sums blocks of pixels, if it can. Call it under a GlStateGuard.
  void add(const Source& source, bool in_software, GlReadBuffer& buffer,
           RenderStatistics& statistics);
  void release();

 private:
  Result<void> sum_blocks(const Source& source, int columns, int rows);

  std::unique_ptr<GlProgram> program_;
  GlTarget sums_;
  std::vector<RgbaF> read_;
};

}  // namespace nav::render
