// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/organ_grid.hpp"

#include <cmath>
#include <tbb/parallel_for.h>

#include "nav/check.hpp"

namespace nav::sim {
namespace {

/// Half the diagonal of a cell, with room for distances that are only first-order, plus the width
/// of the blended boundary.
double reach_mm(double cell_mm) { return 1.4 * 0.8660254 * cell_mm + 1.0; }

}  // namespace

OrganGrid::OrganGrid(const std::vector<Organ>& organs, const Eigen::AlignedBox3d& box,
                     double cell_mm)
    : box_(box), cell_mm_(cell_mm) {
  const double reach = reach_mm(cell_mm);
  NAV_CHECK(organs.size() < 65536, organs.size());
  size_ = (box_.sizes().array() / cell_mm_).ceil().cast<int>();
  const auto cells = static_cast<std::size_t>(size_.prod());
  const auto slice = static_cast<std::size_t>(size_.x() * size_.y());
  std::vector<std::vector<std::uint16_t>> found(cells);
  filled_.assign(cells, 0);
  tbb::parallel_for(0, size_.z(), [&](int k) {
    for (std::size_t o = 0; o < organs.size(); ++o) {
      const Organ& organ = organs[o];
      const auto first = ((organ.bounds.min() - box_.min()).array() / cell_mm_).floor() - 1.0;
      const auto last = ((organ.bounds.max() - box_.min()).array() / cell_mm_).floor() + 1.0;
      const Eigen::Array3i lo = first.cwiseMax(0.0).cast<int>();
      const Eigen::Array3i hi = last.cast<int>().cwiseMin(size_ - 1);
      if (k < lo.z() || k > hi.z()) continue;
      for (int j = lo.y(); j <= hi.y(); ++j) {
        for (int i = lo.x(); i <= hi.x(); ++i) {
          const Eigen::Vector3d centre =
              box_.min() + cell_mm_ * (Eigen::Vector3d(i, j, k).array() + 0.5).matrix();
          const double d = organ.distance_mm(centre);
          if (d > reach) continue;
          const std::size_t cell =
              static_cast<std::size_t>(k) * slice + static_cast<std::size_t>(j * size_.x() + i);
          auto& list = found[cell];
          if (d < -reach) {
            list.clear();
            filled_[cell] = 1;
          }
          list.push_back(static_cast<std::uint16_t>(o));
        }
      }
    }
  });
  start_.reserve(cells + 1);
  for (const auto& list : found) {
    start_.push_back(static_cast<std::uint32_t>(lists_.size()));
    lists_.insert(lists_.end(), list.begin(), list.end());
  }
  start_.push_back(static_cast<std::uint32_t>(lists_.size()));
  for (std::size_t o = 0; o < organs.size(); ++o) all_.push_back(static_cast<std::uint16_t>(o));
}

OrgansNear OrganGrid::organs_at(const Eigen::Vector3d& p) const {
  if (!box_.contains(p)) return {all_, false};
  const Eigen::Array3i c =
      ((p - box_.min()).array() / cell_mm_).cast<int>().cwiseMax(0).cwiseMin(size_ - 1);
  const auto cell =
      static_cast<std::size_t>(c.z()) * static_cast<std::size_t>(size_.x() * size_.y()) +
      static_cast<std::size_t>(c.y() * size_.x() + c.x());
  return {std::span(lists_).subspan(start_[cell], start_[cell + 1] - start_[cell]),
          filled_[cell] != 0};
}

}  // namespace nav::sim
