// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "render/spec/ray_spec.hpp"
#include "render/surfaces.hpp"

namespace nav::render {

/// Capsules around the surfaces of a scene: where no ray of a block of pixels meets one, no ray has
/// to be asked. Thread-safe to read.
class SurfaceBounds {
 public:
  explicit SurfaceBounds(const Scene& scene);
  /// What some ray of the block of size × size pixels from (x0, y0) on may meet.
  [[nodiscard]] SurfaceReach reach(const spec::View<double>& view, int x0, int y0, int size) const;

 private:
  struct Capsule {
    Eigen::Vector3d from;  ///< Local mm.
    Eigen::Vector3d to;
    double radius;
  };
  void add(const Eigen::Vector3d& from_ct, const Eigen::Vector3d& to_ct, double radius_mm);
  Eigen::Vector3d origin_;
  std::vector<Capsule> capsules_;   ///< That of the ultrasound picture first, if there is one.
  std::ptrdiff_t first_shape_ = 0;  ///< 1 with an ultrasound picture.
};

}  // namespace nav::render
