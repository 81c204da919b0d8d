// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/volume.hpp"

namespace nav::sim {

/// Applies a Gaussian blur along one axis of a float volume; the border is repeated. Private to
/// sim/.
void blur_axis(std::vector<float>& voxels, const VoxelGrid& grid, std::size_t axis,
               double sigma_voxels);

}  // namespace nav::sim
