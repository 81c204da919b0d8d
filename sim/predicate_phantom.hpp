// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "nav/volume.hpp"

namespace nav::sim {

/// A simulated 3D ultrasound volume, and what is known about it because it is simulated.
struct PredicatePhantom {
  std::string name;
  std::shared_ptr<const StoredVolume> ultrasound;  ///< Values 0 to 255.
  Point<frames::Ct> face_ct;                       ///< A point of the plane with depth 0.
  Direction<frames::Ct> into_ct;  ///< Parallel scan lines, away from the probe; unit.
  /// Layers of tissue, one bit each, i fastest, on the volume's grid.
  std::vector<std::uint32_t> labels;
  std::string labels_name;
};

/// A neck, a cube of 40 mm in n voxels along each axis: skin (label bit 0), muscle (bit 1) and a
/// forked vessel below it (bit 2), with Rayleigh speckle and attenuation, scanned by parallel lines
/// along +y.
Result<PredicatePhantom> neck_volume(int n);

/// Exact vesselness of neck_volume() on its grid, [0, 1], i fastest: 1 in the vessel, falling with
/// the distance from its wall.
std::vector<float> neck_vesselness(const VoxelGrid& grid);

}  // namespace nav::sim
