// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_state.hpp"
// GLEW comes first, because every other GL header depends on it.
#include <Eigen/Core>

#include "render/gl/gl_cost_sums.hpp"
#include "render/gl/gl_uniforms.hpp"

namespace nav::render {

void GlCostSums::add(const Source& source, bool in_software, GlReadBuffer& buffer,
                     RenderStatistics& statistics) {
  constexpr int kBlock = 16;                    // Same as in shaders/cost_sums.frag.
  constexpr std::uint32_t kCut = 512;           // More than the rays of a block.
  Eigen::Array3d sum = Eigen::Array3d::Zero();  // Whole numbers, exact.
  std::uint64_t rays = 0;
  std::uint64_t cut = 0;
  const int columns = (source.width + kBlock - 1) / kBlock;
  const int rows = (source.height + kBlock - 1) / kBlock;
  if (in_software || !sum_blocks(source, columns, rows)) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, source.framebuffer);
    buffer.read(GL_COLOR_ATTACHMENT1, source.width, source.height, in_software, read_);
    for (const auto& [samples, gradients, faded, kind] : read_) {
      sum += Eigen::Array3d(samples, gradients, faded);
      rays += kind > 0 ? 1 : 0;
      cut += kind > 1 ? 1 : 0;
    }
  } else {
    buffer.read(GL_COLOR_ATTACHMENT0, columns, rows, false, read_);
    for (const auto& [samples, gradients, faded, both] : read_) {
      sum += Eigen::Array3d(samples, gradients, faded);
      rays += static_cast<std::uint32_t>(both) % kCut;
      cut += static_cast<std::uint32_t>(both) / kCut;
    }
  }
  statistics.volume_samples += static_cast<std::uint64_t>(sum[0]);
  statistics.gradient_samples += static_cast<std::uint64_t>(sum[1]);
  statistics.faded_cells += static_cast<std::uint64_t>(sum[2]);
  statistics.rays += rays;
  statistics.cutaway_rays += cut;
}

/// Sums into a framebuffer, which is bound afterwards.
Result<void> GlCostSums::sum_blocks(const Source& source, int columns, int rows) {
  if (!program_) {
    auto linked = GlProgram::link_fullscreen(assembled_shader("cost_sums.frag"));
    if (!linked) return linked.error();
    program_ = std::move(linked).value();
  }
  if (auto ok = sums_.bind(columns, rows); !ok) return ok;
  program_->use();
  program_->set("spent", kTarget);
  glBindTexture(GL_TEXTURE_2D, source.texture);
  sums_.draw();
  glBindTexture(GL_TEXTURE_2D, 0);
  return {};
}

void GlCostSums::release() {
  program_.reset();
  sums_.release();
  read_ = {};
}

}  // namespace nav::render
