// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/blur.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace nav::sim {

void blur_axis(std::vector<float>& voxels, const VoxelGrid& grid, std::size_t axis,
               double sigma_voxels) {
  const int radius = static_cast<int>(std::ceil(3 * sigma_voxels));
  if (radius < 1 || sigma_voxels < 0.1) return;
  std::vector<float> weights(static_cast<std::size_t>(2 * radius + 1));
  double sum = 0;
  for (int i = -radius; i <= radius; ++i)
    sum += std::exp(-0.5 * i * i / (sigma_voxels * sigma_voxels));
  for (int i = -radius; i <= radius; ++i) {
    weights[static_cast<std::size_t>(i + radius)] =
        static_cast<float>(std::exp(-0.5 * i * i / (sigma_voxels * sigma_voxels)) / sum);
  }
  const auto nx = static_cast<std::size_t>(grid.size[0]);
  const auto ny = static_cast<std::size_t>(grid.size[1]);
  const auto nz = static_cast<std::size_t>(grid.size[2]);
  const std::array<std::size_t, 3> stride = {1, nx, nx * ny};
  const int count = grid.size[axis];
  const std::size_t rows_u = axis == 0 ? ny : nx;
  const std::size_t rows_v = axis == 2 ? ny : nz;
  const std::size_t step_u = axis == 0 ? stride[1] : stride[0];
  const std::size_t step_v = axis == 2 ? stride[1] : stride[2];
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows_v), [&](const auto& range) {
    std::vector<float> line(static_cast<std::size_t>(count));
    for (std::size_t v = range.begin(); v != range.end(); ++v) {
      for (std::size_t u = 0; u < rows_u; ++u) {
        float* row = voxels.data() + u * step_u + v * step_v;
        for (int i = 0; i < count; ++i) {
          line[static_cast<std::size_t>(i)] = row[static_cast<std::size_t>(i) * stride[axis]];
        }
        for (int i = 0; i < count; ++i) {
          float value = 0;
          for (int k = -radius; k <= radius; ++k) {
            value += weights[static_cast<std::size_t>(k + radius)] *
                     line[static_cast<std::size_t>(std::clamp(i + k, 0, count - 1))];
          }
          row[static_cast<std::size_t>(i) * stride[axis]] = value;
        }
      }
    }
  });
}

}  // namespace nav::sim
