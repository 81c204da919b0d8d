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

/// A 3D ultrasound volume from a matrix probe, a mechanically swept probe, or a reconstruction.
struct UltrasoundVolume {
  /// Positions of the voxels, but in Reference coordinates, mm.
  VoxelGrid grid;
  std::vector<std::uint8_t> grey;  ///< i fastest, then j, then k; 0 if nothing was measured.
  int lateral_axis = 0;            ///< Voxel axis that runs across the scan lines.
  int depth_axis = 1;  ///< Voxel axis that runs along the scan lines, away from the transducer.
  /// The part of every slice that scan lines reached, the same in every slice: x along the lateral
  /// axis from the middle of the slice, y along the depth axis from its first voxel, mm; absent:
  /// the whole slice.
  std::optional<SectorOutline> outline;
  std::string name;
};

/// Converts the volume to the sweep of its slices across the third axis, which register_sweep()
/// accepts like ultrasound images: no voxel is resampled. Rejects a bad grid, a wrong number of
/// voxels, axes that are not two different ones of 0, 1, 2, and a volume of fewer than 2 slices.
Result<Sweep> sweep_of_volume(const UltrasoundVolume& volume);

}  // namespace nav::registration
