// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/volume.hpp"

namespace nav::tracking {

/// Box of points, and how far its images moved.
struct SweepExtent {
  Eigen::Vector3d low_mm, high_mm;  ///< Reference frame.
  double motion_mm = 0;             ///< Furthest that a corner of the first image moved.
};
/// \p corners: four of each image, in one order, Reference frame. Precondition: not empty.
SweepExtent sweep_extent(const std::vector<Point<frames::Reference>>& corners);

/// Grid along the axes of the Reference frame whose first voxel centre is the lower corner of the
/// box, as in PLUS, and that covers it; \p margin more voxels at each side. Rejects a spacing
/// outside [1e-4, 1e3] mm and more than 2^31 voxels.
Result<VoxelGridIn<frames::Reference>> sweep_grid(const SweepExtent& extent, double spacing_mm,
                                                  int margin);

}  // namespace nav::tracking
