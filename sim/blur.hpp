// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/volume.hpp"

namespace nav::sim {

/// One axis of the Gaussian blur over a float volume, border repeated. Private to sim/.
void blur_axis(std::vector<float>& voxels, const VoxelGrid& grid, std::size_t axis,
               double sigma_voxels);

}  // namespace nav::sim
