// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "nav/volume.hpp"

namespace nav::render {

/// Differences of the two neighbours of every voxel along i, j, k, HU, and a zero: four numbers
/// each. A missing neighbour is replaced by the voxel itself. Interpolated between voxels they are
/// the central differences of the interpolated volume, because both are linear: one fetch instead
/// of six. Empty if a difference does not fit into 16 bits. Internal to render/.
std::vector<std::int16_t> neighbour_differences(const StoredVolume& volume);

/// The largest number of voxels for which eight bytes each are worth their memory: 512 MiB.
inline constexpr std::size_t kMostGradientVoxels = std::size_t{1} << 26;

}  // namespace nav::render
