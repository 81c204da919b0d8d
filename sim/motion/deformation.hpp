// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "sim/motion/warp.hpp"

namespace nav::sim {

/// Deformation of the tissue between the CT and the images: by a probe, a needle, or another
/// posture. It does not change during a recording.
struct DeformationOptions {
  double largest_mm = 0;  ///< Displacement of the target that moves most, [0, 20]; 0: none.
  std::uint64_t seed = 1;
};

/// Rejects invalid options; the message gives the value.
Result<void> validate(const DeformationOptions& options);

/// Three smooth bumps, 40 to 60 mm wide (standard deviation, each axis), with centres within 30 mm
/// of the centre of \p points_ct. They are scaled together so that the point that moves most moves
/// by largest_mm. Closed form, one-to-one. Errors: those of validate(); kUsage without points, and
/// those of SmoothWarp::create().
Result<SmoothWarp> make_deformation(const DeformationOptions& options,
                                    std::span<const Point<frames::Ct>> points_ct);

}  // namespace nav::sim
