// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "nav/volume.hpp"

namespace nav::render {

/// Voxels along a brick's edge.
inline constexpr int kGlBrickVoxels = 8;

/// Least and greatest HU of the voxels that a trilinear sample inside each brick can touch: brick
/// b holds the continuous indices [8 b, 8 b + 8], hence nine voxels per axis. Order: i fastest.
struct GlBrickRanges {
  Eigen::Vector3i count = Eigen::Vector3i::Zero();
  std::vector<std::int16_t> low, high;
};
GlBrickRanges gl_brick_ranges(const Volume& volume);

/// Chebyshev distance of each brick to the nearest one for which occupied(low, high) holds, in
/// bricks, at most 255; 0: occupied itself.
std::vector<std::uint8_t> gl_brick_distances(
    const GlBrickRanges& ranges, const std::function<bool(std::int16_t, std::int16_t)>& occupied);

}  // namespace nav::render
