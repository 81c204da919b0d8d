// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "nav/sweep.hpp"

namespace nav::registration {

/// Which pixels of a sweep carry echoes. Shadows and lost contact are strong edges that the CT
/// does not show; with them in, LC2's best pose lies tens of millimetres off.
struct ShadowMaskOptions {
  double near_field_mm = 10;   ///< Depth below the transducer that is never used, >= 0.
  int drop_grey = 45;          ///< How far below the sweep's usual grey a line has ended, 1 to 254.
  int neighbour_lines = 4;     ///< A line ends where the worst of its neighbours ends, >= 0.
  double line_spacing_mm = 1;  ///< Distance of scan lines at mid depth, > 0.
};

/// A refusal that names the first option out of its range.
Result<void> validate(const ShadowMaskOptions& options);

/// Whether pictures have their pixels and their outline at the same places of the Image frame.
bool same_geometry(const UltrasoundFrame& a, const UltrasoundFrame& b);

/// For each picture 1 where echoes are usable, else 0; same size as the picture.
/// A scan line (a ray from the apex where the picture has an outline, else a column) ends at its
/// last sample that is brighter than the 75th percentile of the whole sweep at that depth minus
/// drop_grey; from there on is shadow, noise or air. Without an outline, what is black in every
/// picture up to its border is left out. Errors: kUsage (options), kMalformedData
/// (pixel grid or outline that cannot be). Deterministic; thread-safe.
Result<std::vector<Image2d<std::uint8_t>>> shadow_masks(const Sweep& sweep,
                                                        const ShadowMaskOptions& options);

}  // namespace nav::registration
