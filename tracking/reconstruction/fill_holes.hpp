// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nav/result.hpp"
#include "tracking/reconstruction/reconstruction.hpp"

namespace nav::tracking {

/// Origin of a voxel's value.
enum class VoxelOrigin : std::uint8_t { kEmpty = 0, kSeen = 1, kFilled = 2 };

/// Fills voxels of value kUnseenVoxel that lie between two seen ones: on the shortest of the 13
/// lines along axes and diagonals whose seen ends are at most \p most_steps + 1 steps apart, the
/// value is interpolated linearly. Ties: the mean of the lines. Nothing is extrapolated. Returns
/// the origin of each voxel; kCancelled when stopped. The result does not depend on the threads
/// (0: all cores). Preconditions: most_steps >= 0; values.size() is that of the grid.
Result<std::vector<VoxelOrigin>> fill_holes(const std::array<int, 3>& size, int most_steps,
                                            int threads, std::vector<std::int16_t>& values,
                                            const ReconstructionRun& run = {});

}  // namespace nav::tracking
