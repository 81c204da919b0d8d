// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/reconstruction/sweep_grid.hpp"

#include <cmath>
#include <sstream>

namespace nav::tracking {

SweepExtent sweep_extent(const std::vector<Point<frames::Reference>>& corners) {
  NAV_CHECK(corners.size() >= 4 && corners.size() % 4 == 0, corners.size());
  SweepExtent extent{corners.front().mm, corners.front().mm};
  for (std::size_t n = 0; n < corners.size(); ++n) {
    extent.low_mm = extent.low_mm.cwiseMin(corners[n].mm);
    extent.high_mm = extent.high_mm.cwiseMax(corners[n].mm);
    extent.motion_mm = std::max(extent.motion_mm, (corners[n].mm - corners[n % 4].mm).norm());
  }
  return extent;
}

Result<VoxelGridIn<frames::Reference>> sweep_grid(const SweepExtent& extent, double spacing_mm,
                                                  int margin) {
  if (!(spacing_mm >= 1e-4 && spacing_mm <= 1e3)) {
    std::ostringstream text;
    text << "voxel spacing: expected 0.0001 to 1000 mm, found " << spacing_mm;
    return Error{ErrorCode::kUsage, text.str()};
  }
  const Eigen::Vector3d box = extent.high_mm - extent.low_mm;
  // Rounding must not add a voxel.
  const Eigen::Vector3d steps = ((box / spacing_mm).array() - 1e-6).ceil().cwiseMax(0);
  const Eigen::Vector3d size = steps.array() + 1 + 2 * margin;
  constexpr double kMost = 2147483648.0;
  if (!(size.prod() <= kMost)) {
    std::ostringstream text;
    text << "volume: expected at most 2^31 voxels, found " << size.prod() << " (" << size.x()
         << " x " << size.y() << " x " << size.z() << ") at " << spacing_mm << " mm";
    return Error{ErrorCode::kUsage, text.str()};
  }
  VoxelGridIn<frames::Reference> grid;
  grid.size = {static_cast<int>(size.x()), static_cast<int>(size.y()), static_cast<int>(size.z())};
  grid.spacing_mm = Eigen::Vector3d::Constant(spacing_mm);
  grid.origin_mm = extent.low_mm - Eigen::Vector3d::Constant(margin * spacing_mm);
  return grid;
}

}  // namespace nav::tracking
