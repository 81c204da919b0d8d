// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <string>

#include "nav/volume.hpp"

namespace nav::render {

/// A volume with fewer voxels in place of a larger one. Internal to render/.
struct ReducedVolume {
  std::shared_ptr<const StoredVolume> volume;
  std::array<int, 3> factors;  ///< Voxels of the full volume per voxel, per axis.
  double max_error_hu;         ///< Trilinear, at the voxel centres of the full volume.
  double rms_error_hu;
};

/// Averages boxes of voxels; boxes at the far faces may be smaller. factors >= 1.
ReducedVolume reduced(const StoredVolume& full, const std::array<int, 3>& factors);

/// The least factors that bring every edge within a limit, then the volume within a number of
/// voxels, by halving the longest edge each time.
std::array<int, 3> factors_to_fit(const std::array<int, 3>& size, int largest_edge,
                                  std::size_t most_voxels);

/// One sentence for the user on the reduction.
std::string note_of(const ReducedVolume& reduced, const StoredVolume& full);

}  // namespace nav::render
