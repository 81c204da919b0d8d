// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/ray_spec.hpp"

namespace nav::render {

/// Balls around the surfaces of a scene: where no ray of a block of pixels meets one, no ray has to
/// be asked. Thread-safe to read.
class SurfaceBounds {
 public:
  explicit SurfaceBounds(const Scene& scene);
  /// False: no ray of the block of size × size pixels from (x0, y0) on meets a surface.
  [[nodiscard]] bool reach(const spec::View<double>& view, int x0, int y0, int size) const;

 private:
  struct Ball {
    Eigen::Vector3d centre;  ///< Local mm.
    double radius;
  };
  void add(const std::vector<Eigen::Vector3d>& points_ct, double radius_mm);

  Eigen::Vector3d origin_;
  std::vector<Ball> balls_;
};

}  // namespace nav::render
