// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/volume.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace nav {

Point<frames::Ct> VoxelGrid::centre() const {
  return at(0.5 * Eigen::Vector3d(size[0] - 1, size[1] - 1, size[2] - 1));
}

Eigen::Vector3d VoxelGrid::extent_mm() const {
  return spacing_mm.cwiseProduct(Eigen::Vector3d(size[0], size[1], size[2]));
}

Result<void> validate(const VoxelGrid& grid, const std::string& name) {
  const auto refuse = [&](const std::string& expected, const std::string& found) {
    return Error{ErrorCode::kMalformedData, name + ": expected " + expected + ", found " + found};
  };
  constexpr double kMaxVoxels = 2147483648.0;
  double voxels = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (grid.size[a] < 1) {
      return refuse("at least 1 voxel along axis " + std::to_string(axis),
                    std::to_string(grid.size[a]));
    }
    voxels *= grid.size[a];
    const double spacing = grid.spacing_mm[axis];
    // The limits are a tenth of a micrometre and a metre, beyond every scanner.
    if (!(spacing >= 1e-4 && spacing <= 1e3)) {
      std::ostringstream found;
      found << spacing;
      return refuse("a spacing of 0.0001 to 1000 mm along axis " + std::to_string(axis),
                    found.str());
    }
  }
  std::ostringstream found;
  if (voxels > kMaxVoxels) {
    found << grid.size[0] << " x " << grid.size[1] << " x " << grid.size[2];
    return refuse("at most 2^31 voxels", found.str());
  }
  if (!grid.origin_mm.allFinite()) {
    found << grid.origin_mm.transpose();
    return refuse("a finite origin in mm", found.str());
  }
  const Eigen::Matrix3d& d = grid.directions;
  if (!d.allFinite() ||
      (d.transpose() * d - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-4) {
    found << "[" << d.row(0) << "; " << d.row(1) << "; " << d.row(2) << "]";
    return refuse("orthonormal direction columns", found.str());
  }
  return {};
}

Result<Volume> Volume::create(const VoxelGrid& grid, std::vector<std::int16_t> hu,
                              std::string name) {
  if (const auto ok = validate(grid, name); !ok) return ok.error();
  if (hu.size() != grid.voxel_count()) {
    return Error{ErrorCode::kMalformedData, name + ": expected " +
                                                std::to_string(grid.voxel_count()) +
                                                " voxels, found " + std::to_string(hu.size())};
  }
  return Volume(grid, std::make_shared<const std::vector<std::int16_t>>(std::move(hu)),
                std::move(name));
}

std::int16_t Volume::at(int i, int j, int k) const {
  NAV_CHECK(
      i >= 0 && i < grid_.size[0] && j >= 0 && j < grid_.size[1] && k >= 0 && k < grid_.size[2], i,
      j, k);
  const auto row = static_cast<std::size_t>(grid_.size[0]);
  const auto slice = row * static_cast<std::size_t>(grid_.size[1]);
  return (*hu_)[static_cast<std::size_t>(k) * slice + static_cast<std::size_t>(j) * row +
                static_cast<std::size_t>(i)];
}

std::optional<double> Volume::sample(const Point<frames::Ct>& p) const {
  const Eigen::Vector3d index = grid_.index_of(p);
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  Eigen::Vector3d w;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int last = grid_.size[a] - 1;
    // Rounding must not move a point on the border outside.
    constexpr double kBorderTolerance = 1e-9;
    if (!(index[axis] >= -kBorderTolerance && index[axis] <= last + kBorderTolerance)) return {};
    const double clamped = std::clamp(index[axis], 0.0, static_cast<double>(last));
    low[a] = std::min(static_cast<int>(clamped), std::max(last - 1, 0));
    high[a] = std::min(low[a] + 1, last);
    w[axis] = clamped - low[a];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const bool x = (corner & 1) != 0;
    const bool y = (corner & 2) != 0;
    const bool z = (corner & 4) != 0;
    const double weight =
        (x ? w.x() : 1 - w.x()) * (y ? w.y() : 1 - w.y()) * (z ? w.z() : 1 - w.z());
    sum += weight * at(x ? high[0] : low[0], y ? high[1] : low[1], z ? high[2] : low[2]);
  }
  return sum;
}

}  // namespace nav
