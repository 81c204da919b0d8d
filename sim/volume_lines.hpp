// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "sim/anatomy/dual.hpp"
#include "sim/ultrasound_volume.hpp"

namespace nav::sim {

/// Scan lines of a three-dimensional acquisition: a grid of across by along lines, each with one
/// sample per voxel in depth. Private to sim/.
class VolumeLines {
 public:
  VolumeLines(const Transform<frames::Ct, frames::Image>& pose, const UltrasoundVolumeOptions& o)
      : options_(o), pose_(pose) {
    const double reach = o.depth_mm + o.apex_mm;
    for (const int axis : {0, 2}) {
      const auto a = static_cast<std::size_t>(axis);
      const double extent = axis == 0 ? o.width_mm : o.thickness_mm;
      // For parallel lines in mm; from an apex as tangents.
      step_[a] = extent / (o.size[a] - 1) / (parallel() ? 1.0 : reach);
      first_[a] = -0.5 * step_[a] * (o.size[a] - 1);
    }
    step_mm_ = o.depth_mm / (o.size[1] - 1);
  }
  [[nodiscard]] bool parallel() const { return !(options_.apex_mm > 0); }
  [[nodiscard]] std::size_t count(int axis) const {
    return static_cast<std::size_t>(options_.size[static_cast<std::size_t>(axis)]);
  }
  [[nodiscard]] double step_mm() const { return step_mm_; }
  /// Distance between neighbouring lines along an axis (0 or 2) at a depth.
  [[nodiscard]] double spacing_mm(std::size_t axis, double along_mm) const {
    return parallel() ? step_[axis] : step_[axis] * (options_.apex_mm + along_mm);
  }
  /// Start and unit direction of a line, CT coordinates.
  void line(std::size_t i, std::size_t k, Vec3d& start, Vec3d& along) const {
    const double u = first_[0] + step_[0] * static_cast<double>(i);
    const double v = first_[2] + step_[2] * static_cast<double>(k);
    Vec3d from(u, 0, v);
    Vec3d way = Vec3d::UnitY();
    if (!parallel()) {
      way = Vec3d(u, 1, v).normalized();
      from = Vec3d(0, -options_.apex_mm, 0) + options_.apex_mm * way;
    }
    start = (pose_ * Point<frames::Image>{from}).mm;
    along = (pose_ * Direction<frames::Image>{way}).v;
  }
  /// Grid of the voxels over the full extent, CT coordinates, with the axes of the Image frame.
  [[nodiscard]] VoxelGrid voxels() const {
    VoxelGrid grid;
    grid.size = options_.size;
    const Vec3d extent(options_.width_mm, options_.depth_mm, options_.thickness_mm);
    for (int a = 0; a < 3; ++a) {
      grid.spacing_mm[a] = extent[a] / (options_.size[static_cast<std::size_t>(a)] - 1);
    }
    const Vec3d corner(-0.5 * extent.x(), 0, -0.5 * extent.z());
    grid.origin_mm = (pose_ * Point<frames::Image>{corner}).mm;
    grid.directions = pose_.rotation().toRotationMatrix();
    return grid;
  }
  /// Continuous index (line across, sample, line along) of a voxel.
  [[nodiscard]] Vec3d beam_index(const Vec3d& voxel) const {
    if (parallel()) return voxel;
    const VoxelGrid& g = grid_;
    const Vec3d p(-0.5 * options_.width_mm + voxel.x() * g.spacing_mm.x(),
                  options_.apex_mm + voxel.y() * g.spacing_mm.y(),
                  -0.5 * options_.thickness_mm + voxel.z() * g.spacing_mm.z());
    return {(p.x() / p.y() - first_[0]) / step_[0], (p.norm() - options_.apex_mm) / step_mm_,
            (p.z() / p.y() - first_[2]) / step_[2]};
  }

 private:
  UltrasoundVolumeOptions options_;
  Transform<frames::Ct, frames::Image> pose_;
  std::array<double, 3> step_{};
  std::array<double, 3> first_{};
  double step_mm_ = 0;
  VoxelGrid grid_ = voxels();
};

}  // namespace nav::sim
