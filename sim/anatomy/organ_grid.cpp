// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/organ_grid.hpp"

#include <cmath>
#include <tbb/parallel_for.h>

#include "nav/check.hpp"

namespace nav::sim {
namespace {

/// Half the diagonal of a cell, enlarged for first-order distances and for the width of the blended
/// boundary.
double reach_mm(double cell_mm) { return 1.4 * 0.8660254 * cell_mm + 1.0; }

constexpr std::size_t kMostToSplit = 1;
}  // namespace

void OrganGrid::Found::add(std::uint16_t organ, double distance_mm, double reach_mm) {
  if (distance_mm > reach_mm) return;
  if (distance_mm < -reach_mm) {
    organs.clear();
    filled = true;
  }
  organs.push_back(organ);
}

OrganGrid::OrganGrid(const std::vector<Organ>& organs, const Eigen::AlignedBox3d& box,
                     double cell_mm)
    : box_(box), cell_mm_(cell_mm), cells_per_mm_(1 / cell_mm) {
  NAV_CHECK(organs.size() < 65536, organs.size());
  size_ = (box_.sizes().array() / cell_mm_).ceil().cast<int>();
  const std::vector<Found> found = fill(organs);
  std::vector<std::vector<Found>> parts(found.size());  // Most remain empty.
  const auto splits = [&](std::size_t c) {
    const std::size_t surfaces = found[c].organs.size() - (found[c].filled ? 1U : 0U);
    return surfaces > 0 && surfaces <= kMostToSplit;
  };
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t c) {
    if (!splits(c)) return;
    const auto nx = static_cast<std::size_t>(size_.x());
    const auto ny = static_cast<std::size_t>(size_.y());
    const Eigen::Vector3d index(static_cast<double>(c % nx), static_cast<double>(c / nx % ny),
                                static_cast<double>(c / nx / ny));
    parts[c] = split(organs, found[c], box_.min() + cell_mm_ * index);
  });
  cells_.reserve(found.size());
  for (std::size_t c = 0; c < found.size(); ++c) {
    if (!splits(c)) {
      cells_.push_back(keep(found[c]));
      continue;
    }
    cells_.push_back({static_cast<std::uint32_t>(children_.size()), 0, false, true});
    for (const Found& part : parts[c]) children_.push_back(keep(part));
  }
  for (std::size_t o = 0; o < organs.size(); ++o) all_.push_back(static_cast<std::uint16_t>(o));
}

std::vector<OrganGrid::Found> OrganGrid::fill(const std::vector<Organ>& organs) const {
  const double reach = reach_mm(cell_mm_);
  const auto slice = static_cast<std::size_t>(size_.x() * size_.y());
  std::vector<Found> found(static_cast<std::size_t>(size_.prod()));
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
          found[static_cast<std::size_t>(k) * slice + static_cast<std::size_t>(j * size_.x() + i)]
              .add(static_cast<std::uint16_t>(o), organ.distance_mm(centre), reach);
        }
      }
    }
  });
  return found;
}

std::vector<OrganGrid::Found> OrganGrid::split(const std::vector<Organ>& organs, const Found& cell,
                                               const Eigen::Vector3d& corner) const {
  const double half = 0.5 * cell_mm_;
  std::vector<Found> parts(8);
  for (std::size_t n = 0; n < parts.size(); ++n) {
    const Eigen::Vector3d side(static_cast<double>(n & 1U), static_cast<double>((n >> 1U) & 1U),
                               static_cast<double>(n >> 2U));
    const Eigen::Vector3d centre = corner + half * (side.array() + 0.5).matrix();
    for (std::size_t i = 0; i < cell.organs.size(); ++i) {
      if (i == 0 && cell.filled) {
        parts[n] = {{cell.organs[0]}, true};
      } else {
        const Organ& organ = organs[cell.organs[i]];
        parts[n].add(cell.organs[i], organ.distance_mm(centre), reach_mm(half));
      }
    }
  }
  return parts;
}

OrganGrid::Cell OrganGrid::keep(const Found& found) {
  const Cell cell{static_cast<std::uint32_t>(lists_.size()),
                  static_cast<std::uint16_t>(found.organs.size()), found.filled, false};
  lists_.insert(lists_.end(), found.organs.begin(), found.organs.end());
  return cell;
}

OrgansNear OrganGrid::organs_at(const Eigen::Vector3d& p) const {
  if (!box_.contains(p)) return {all_, false};
  const Eigen::Array3d at = (p - box_.min()).array() * cells_per_mm_;
  const Eigen::Array3i c = at.cast<int>().cwiseMax(0).cwiseMin(size_ - 1);
  const Cell* cell =
      &cells_[static_cast<std::size_t>(c.z()) * static_cast<std::size_t>(size_.x() * size_.y()) +
              static_cast<std::size_t>(c.y() * size_.x() + c.x())];
  if (cell->split) {
    const auto upper = at - c.cast<double>() >= 0.5;
    cell = &children_[cell->start + (upper.x() ? 1U : 0U) + (upper.y() ? 2U : 0U) +
                      (upper.z() ? 4U : 0U)];
  }
  return {std::span(lists_).subspan(cell->start, cell->count), cell->filled};
}

}  // namespace nav::sim
