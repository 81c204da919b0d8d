// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nav/sweep.hpp"
#include "nav/volume.hpp"

namespace nav::registration {

/// A 3D ultrasound volume: from a matrix probe, a wobbler, or a reconstruction.
struct UltrasoundVolume {
  /// Where the voxels lie, but in Reference coordinates, mm.
  VoxelGrid grid;
  std::vector<std::uint8_t> grey;  ///< i fastest, then j, then k; 0 where nothing was seen.
  int lateral_axis = 0;            ///< Voxel axis that runs across the scan lines.
  int depth_axis = 1;              ///< Voxel axis that runs with them, away from the transducer.
  /// The part that scan lines reached, in every slice alike: x along the lateral axis from the
  /// middle of the slice, y along the depth axis from its first voxel, mm; absent: all of it.
  std::optional<SectorOutline> outline;
  std::string name;
};

/// The volume as the sweep of its slices across the third axis, which register_sweep() takes like
/// pictures: no voxel is resampled. Refuses a bad grid, another number of voxels, axes that are not
/// two different ones of 0, 1, 2, and a volume of fewer than 2 slices.
Result<Sweep> sweep_of_volume(const UltrasoundVolume& volume);

}  // namespace nav::registration
