// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_state.hpp"
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>
#include <array>
#include <cmath>

#include "render/gl/gl_filter_probe.hpp"
#include "render/gl/gl_program.hpp"
#include "render/gl/gl_target.hpp"
#include "render/gl/gl_uniforms.hpp"

namespace nav::render {

Result<bool> filter_is_coarse() {
  constexpr int kUnit = kTarget;
  constexpr int kFractions = 1024;
  constexpr double kTolerance = 1e-4;  // 0.1 HU at a step of 1000 HU; 8-bit fractions err by 2e-3.
  auto program = GlProgram::link_fullscreen(assembled_shader("filter_probe.frag"));
  if (!program) return program.error();
  glActiveTexture(GL_TEXTURE0 + kUnit);
  GlTexture texels;
  GlTarget target;
  constexpr std::array<std::int16_t, 2> kZeroAndOne{0, 32767};
  glBindTexture(GL_TEXTURE_3D, texels.id());
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_R16_SNORM, 2, 1, 1, 0, GL_RED, GL_SHORT, kZeroAndOne.data());
  if (auto ok = target.bind(kFractions, 1); !ok) return ok.error();
  (*program)->use();
  (*program)->set("two_texels", kUnit);
  (*program)->set("sample_count", static_cast<double>(kFractions));
  target.draw();
  std::array<float, std::size_t{4} * kFractions> values{};
  glReadPixels(0, 0, kFractions, 1, GL_RGBA, GL_FLOAT, values.data());
  glBindTexture(GL_TEXTURE_3D, 0);
  double worst = 0;
  for (int i = 0; i < kFractions; ++i) {
    const double truth = static_cast<double>(i) / kFractions;
    worst = std::max(worst, std::abs(values[std::size_t{4} * static_cast<std::size_t>(i)] - truth));
  }
  return worst > kTolerance;
}

}  // namespace nav::render
