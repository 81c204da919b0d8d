// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <glm/mat2x2.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace nav::render {

/// Converts double precision of the CPU to single precision of the GPU. The only file where Eigen
/// becomes GLM. Both are column-major.
template <int N>
glm::vec<N, float> to_gpu(const Eigen::Matrix<double, N, 1>& v) {
  glm::vec<N, float> out;
  for (int i = 0; i < N; ++i) out[i] = static_cast<float>(v[i]);
  return out;
}
template <int N>
glm::mat<N, N, float> to_gpu(const Eigen::Matrix<double, N, N>& m) {
  glm::mat<N, N, float> out;
  for (int column = 0; column < N; ++column) {
    for (int row = 0; row < N; ++row) out[column][row] = static_cast<float>(m(row, column));
  }
  return out;
}

}  // namespace nav::render
