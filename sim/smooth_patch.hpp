// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "sim/speckle.hpp"

namespace nav::sim {

/// Values of a SmoothField at its nodes in a box, computed once: an image uses the same few nodes a
/// hundred thousand times. Private to sim/. The field must outlive it. Reading is thread-safe.
class SmoothPatch {
 public:
  SmoothPatch(const SmoothField& field, const Eigen::AlignedBox3d& box_mm);
  /// Returns field.at(mm) within float rounding; outside the box it evaluates the field.
  [[nodiscard]] float at(const Eigen::Vector3d& mm) const {
    const Eigen::Array3d q = mm.array() * cells_per_mm_ - first_;
    if (!(q.minCoeff() >= 0 && (q < last_).all())) return field_->at(mm);
    const Eigen::Array3i i = q.cast<int>();
    const Eigen::Array3f t = (q - i.cast<double>()).cast<float>();
    const auto row = static_cast<std::size_t>(size_.x());
    const auto slice = row * static_cast<std::size_t>(size_.y());
    const float* v = nodes_.data() + static_cast<std::size_t>(i.x()) +
                     static_cast<std::size_t>(i.y()) * row +
                     static_cast<std::size_t>(i.z()) * slice;
    const auto along_x = [&](const float* p) { return p[0] + t.x() * (p[1] - p[0]); };
    const auto across = [&](const float* p) {
      const float near = along_x(p);
      return near + t.y() * (along_x(p + row) - near);
    };
    const float near = across(v);
    return near + t.z() * (across(v + slice) - near);
  }

 private:
  const SmoothField* field_;
  double cells_per_mm_;
  Eigen::Array3d first_, last_;  ///< First and last node; the last is counted from the first.
  Eigen::Array3i size_;
  std::vector<float> nodes_;
};

}  // namespace nav::sim
