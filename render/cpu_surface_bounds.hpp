// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "render/ray_spec.hpp"

namespace nav::render {

/// Capsules around the surfaces of a scene: where no ray of a block of pixels meets one, no ray has
/// to be asked. Thread-safe to read.
class SurfaceBounds {
 public:
  explicit SurfaceBounds(const Scene& scene);
  /// False: no ray of the block of size × size pixels from (x0, y0) on meets a surface.
  [[nodiscard]] bool reach(const spec::View<double>& view, int x0, int y0, int size) const;
  /// The same of needle, spheres and lines alone.
  [[nodiscard]] bool reach_shapes(const spec::View<double>& view, int x0, int y0, int size) const;

 private:
  struct Capsule {
    Eigen::Vector3d from;  ///< Local mm.
    Eigen::Vector3d to;
    double radius;
  };
  void add(const Eigen::Vector3d& from_ct, const Eigen::Vector3d& to_ct, double radius_mm);
  [[nodiscard]] bool reach(const spec::View<double>& view, int x0, int y0, int size,
                           std::size_t first) const;

  Eigen::Vector3d origin_;
  std::vector<Capsule> capsules_;  ///< That of the ultrasound picture first, if there is one.
  std::size_t first_shape_ = 0;    ///< 1 with an ultrasound picture.
};

}  // namespace nav::render
