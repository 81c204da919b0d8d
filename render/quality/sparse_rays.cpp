// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/sparse_rays.hpp"

#include "render/spec/ray_spec.hpp"

namespace nav::render {

std::optional<SparseRays> sparse_rays(const Scene& scene) {
  const double error = scene.quality.pixel_error;
  if (!(error > 0) || scene.quality.jitter || scene.predicates || scene.ultrasound) return {};
  const VoxelGrid& grid = scene.ct->grid();
  const auto view = spec::make_view<double>(scene.camera, scene.width, scene.height, grid);
  const Eigen::Vector3d to_middle = grid.centre().mm - grid.origin_mm - view.eye;
  const double away = view.orthographic ? 1 : to_middle.norm();
  const double pixel_mm = away * 2 * view.half_height / scene.height;
  const double widest_mm = 2 * grid.spacing_mm.minCoeff();
  for (const int stride : {4, 2}) {
    if (stride * pixel_mm <= widest_mm) return SparseRays{stride, static_cast<float>(error)};
  }
  return {};
}

}  // namespace nav::render
