// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/smooth_patch.hpp"

namespace nav::sim {

SmoothPatch::SmoothPatch(const SmoothField& field, const Eigen::AlignedBox3d& box_mm)
    : field_(&field),
      cells_per_mm_(1.0 / field.cell_mm()),
      first_((box_mm.min() * cells_per_mm_).array().floor()),
      last_((box_mm.max() * cells_per_mm_).array().floor() - first_ + 1),
      size_(last_.cast<int>() + 1) {
  nodes_.reserve(static_cast<std::size_t>(size_.prod()));
  for (int k = 0; k < size_.z(); ++k) {
    for (int j = 0; j < size_.y(); ++j) {
      for (int i = 0; i < size_.x(); ++i) {
        nodes_.push_back(field.node(first_.cast<int>().matrix() + Eigen::Vector3i(i, j, k)));
      }
    }
  }
}

}  // namespace nav::sim
