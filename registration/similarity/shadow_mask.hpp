// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "nav/sweep.hpp"

namespace nav::registration {

/// Options that decide which pixels of a sweep carry echoes. Shadows and lost contact are strong
/// edges that the CT does not show; with them, the best LC2 pose lies tens of millimetres off.
struct ShadowMaskOptions {
  double near_field_mm = 10;  ///< Depth below the transducer that is never used, >= 0.
  /// A sample this far below the sweep's usual grey is no echo, 1 to 254.
  int drop_grey = 45;
  int neighbour_lines = 4;     ///< A line ends where the shortest of its neighbours ends, >= 0.
  double line_spacing_mm = 1;  ///< Distance of scan lines at mid depth, > 0.
};

/// Returns an error that names the first option that is out of its range.
Result<void> validate(const ShadowMaskOptions& options);

/// True if the pixels and outlines of two ultrasound images have the same positions in the Image
/// frame.
bool same_geometry(const UltrasoundImage& a, const UltrasoundImage& b);

/// Rejects a sweep with an impossible pixel grid or outline, with images more than a metre wide,
/// and with images of different geometry (kMalformedData). The message names the image.
Result<void> check_geometry(const Sweep& sweep);

/// A mask of the size of each ultrasound image: 1 if an echo is usable, else 0. A scan line (a ray
/// from the apex if the image has an outline, else a column) ends where three times
/// the echoes above it exceed the samples without an echo most; beyond it lies shadow, noise or
/// air. An echo is brighter than the 75th percentile of the whole sweep at that depth minus
/// drop_grey, and brighter than the sweep's noise (noise_floor.hpp). Without an outline, pixels
/// that are black in every image and connected to the border are left out. Errors: kUsage
/// (options), kMalformedData (impossible pixel grid or outline). Deterministic; thread-safe.
Result<std::vector<Image2d<std::uint8_t>>> shadow_masks(const Sweep& sweep,
                                                        const ShadowMaskOptions& options);

}  // namespace nav::registration
