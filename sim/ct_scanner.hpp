// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "sim/abdomen_phantom.hpp"

namespace nav::sim {

/// Box of the simulated scan, CT coordinates, mm.
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
};

/// A CT of the phantom; voxel (0,0,0) at region.min_mm, axes along LPS. Noise is white and counter
/// based: the same bytes for any number of threads. Refuses spacing or region that is not finite
/// and positive, negative noise or blur.
Result<Volume> scan_ct(const AbdomenPhantom& phantom, const CtOptions& options = {});

}  // namespace nav::sim
