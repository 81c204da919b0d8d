// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "nav/volume.hpp"
#include "render/spec/ray_spec.hpp"

namespace nav::render {

/// Central-difference gradient of a volume at one voxel, at a continuous index that is clamped to
/// the box of voxel centres. Stored values per mm along the CT axes.
inline spec::Vec3<double> reference_gradient(const StoredVolume& volume,
                                             const spec::Vec3<double>& index) {
  const VoxelGrid& grid = volume.grid();
  spec::Vec3<double> g;
  for (int axis = 0; axis < 3; ++axis) {
    const spec::Vec3<double> one = spec::Vec3<double>::Unit(axis);
    const double last = grid.size[static_cast<std::size_t>(axis)] - 1;
    spec::Vec3<double> centre = index;
    centre[axis] = std::clamp(centre[axis], 0.0, last);
    g[axis] = (spec::value_at(volume, centre + one) - spec::value_at(volume, centre - one)) /
              (2 * grid.spacing_mm[axis]);
  }
  return grid.directions * g;
}

}  // namespace nav::render
