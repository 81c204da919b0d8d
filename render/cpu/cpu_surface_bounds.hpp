// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "render/spec/ray_spec.hpp"
#include "render/surfaces.hpp"

namespace nav::render {

/// Capsules around the surfaces of a scene. If no ray of a block of pixels meets one, no ray of the
/// block has to be tested. Thread-safe to read.
class SurfaceBounds {
 public:
  explicit SurfaceBounds(const Scene& scene);
  /// Surfaces that any ray of the block of size × size pixels that begins at (x0, y0) may meet.
  [[nodiscard]] SurfaceReach reach(const spec::View<double>& view, int x0, int y0, int size) const;

 private:
  struct Capsule {
    Eigen::Vector3d from;  ///< Local mm.
    Eigen::Vector3d to;
    double radius;
  };
  void add(const Eigen::Vector3d& from_ct, const Eigen::Vector3d& to_ct, double radius_mm);
  Eigen::Vector3d origin_;
  std::vector<Capsule> capsules_;   ///< The capsule of the ultrasound image first, if there is one.
  std::ptrdiff_t first_shape_ = 0;  ///< 1 with an ultrasound image.
};

}  // namespace nav::render
