// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "nav/volume.hpp"

namespace nav::render {

/// Differences of the two neighbours of every voxel along i, j, k (the voxel itself where there is
/// none), HU, and a zero: four numbers each. Interpolated between voxels they are the central
/// differences of the interpolated volume, because both are linear: one fetch instead of six.
/// Empty when one does not fit 16 bits. Internal to render/.
std::vector<std::int16_t> neighbour_differences(const Volume& volume);

/// Voxels up to which the eight bytes each are worth their memory: 512 MiB.
inline constexpr std::size_t kMostGradientVoxels = std::size_t{1} << 26;

}  // namespace nav::render
