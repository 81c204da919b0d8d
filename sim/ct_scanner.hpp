// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "nav/volume.hpp"
#include "sim/anatomy/abdomen_phantom.hpp"
#include "sim/anatomy/anatomy.hpp"

namespace nav::sim {

/// Box of the simulated scan, CT coordinates, mm. The default contains the abdomen.
struct CtRegion {
  Eigen::Vector3d min_mm{-150, -120, -110};
  Eigen::Vector3d max_mm{150, 120, 110};
};

struct CtOptions {
  Eigen::Vector3d spacing_mm{1.5, 1.5, 2.0};  ///< > 0.
  double noise_hu = 12;  ///< Standard deviation of the noise in one voxel, >= 0.
  double psf_mm = 0.6;   ///< Standard deviation of the scanner's blur, >= 0; 0: none.
  std::uint64_t seed = 1;
  CtRegion region;
  /// Number of points per axis that are averaged in a voxel, [1, 8]. It adds partial volume, as in
  /// thick slices, to the blended boundary of each point.
  int points_per_axis = 1;
};

/// Simulates a CT of the patient; voxel (0,0,0) is at region.min_mm, axes along LPS. Noise is white
/// and counter-based: the bytes do not depend on the number of threads. Rejects a spacing or region
/// that is not finite and positive, negative noise or blur, and grids of more than 2^31 voxels.
Result<Volume> scan_ct(const Anatomy& patient, const CtOptions& options = {});

/// Simulates a CT on any grid: oblique, thick slices. options.spacing_mm and region are not used.
Result<Volume> scan_ct(const Anatomy& patient, const VoxelGrid& grid, const CtOptions& options);

/// Region that the patient suggests for a scan.
CtRegion region_of(const Anatomy& patient);

}  // namespace nav::sim
