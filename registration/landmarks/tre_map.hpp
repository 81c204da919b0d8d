// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/volume.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

namespace nav::registration {

/// Expected RMS target registration error at the nodes of a grid, mm.
struct TreMap {
  VoxelGrid grid;
  double step_mm;             ///< About so far apart.
  std::vector<float> rms_mm;  ///< i fastest, then j, then k.

  /// Largest value; 0 without nodes.
  [[nodiscard]] double worst_mm() const;
  /// Fraction of the nodes that expect at most so much, [0, 1]; 0 without nodes.
  [[nodiscard]] double fraction_within(double rms_mm) const;
};

/// The map over a CT's box with nodes about step_mm apart (> 0; at least 2 along each axis), or
/// twice, four times, … as far where these would be more than 2^22.
TreMap tre_map(const PoseUncertainty& uncertainty, const VoxelGrid& ct, double step_mm);

}  // namespace nav::registration
