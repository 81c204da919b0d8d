// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include "nav/stopwatch.hpp"
#include "render/gl/gl_timer.hpp"

namespace nav::render {

void GlTimer::begin(bool by_clock) {
  by_clock_ = by_clock;
  if (by_clock_) {
    glFinish();
    start_ = std::chrono::steady_clock::now();
    return;
  }
  if (queries_[0] == 0) glGenQueries(static_cast<GLsizei>(queries_.size()), queries_.data());
  glQueryCounter(queries_[0], GL_TIMESTAMP);
}

double GlTimer::end_s() {
  if (by_clock_) {
    glFinish();
    return seconds_since(start_);
  }
  constexpr double kNanosecond = 1e-9;
  glQueryCounter(queries_[1], GL_TIMESTAMP);
  std::array<GLuint64, 2> at{};
  for (std::size_t i = 0; i < at.size(); ++i)
    glGetQueryObjectui64v(queries_[i], GL_QUERY_RESULT, &at[i]);
  return kNanosecond * static_cast<double>(at[1] - at[0]);
}

void GlTimer::release() {
  if (queries_[0] != 0) glDeleteQueries(static_cast<GLsizei>(queries_.size()), queries_.data());
  queries_ = {};
}

}  // namespace nav::render
