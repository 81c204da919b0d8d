// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "nav/volume.hpp"
#include "sim/abdomen_phantom.hpp"
#include "sim/anatomy/anatomy.hpp"

namespace nav::sim {

/// Box of the simulated scan, CT coordinates, mm; the default holds the abdomen.
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
  /// Points per axis that a voxel averages, [1, 8]: partial volume beyond the blended boundary of
  /// a point, as of thick slices.
  int points_per_axis = 1;
};

/// A CT of the patient; voxel (0,0,0) at region.min_mm, axes along LPS. Noise is white and counter
/// based: the same bytes for any number of threads. Refuses spacing or region that is not finite
/// and positive, negative noise or blur, grids of more than 2^31 voxels.
Result<Volume> scan_ct(const Anatomy& patient, const CtOptions& options = {});

/// The same on any grid: oblique, thick slices; options.spacing_mm and region play no part.
Result<Volume> scan_ct(const Anatomy& patient, const VoxelGrid& grid, const CtOptions& options);

/// The patient's own region.
CtRegion region_of(const Anatomy& patient);

}  // namespace nav::sim
