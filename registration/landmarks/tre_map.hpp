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
  double step_mm;             ///< Approximate distance of neighbouring nodes.
  std::vector<float> rms_mm;  ///< i fastest, then j, then k.

  /// Largest value; 0 if there are no nodes.
  [[nodiscard]] double worst_mm() const;
  /// Fraction of the nodes whose expected error is at most rms_mm, [0, 1]; 0 if there are no nodes.
  [[nodiscard]] double fraction_within(double rms_mm) const;
};

/// The map over the box of a CT with nodes about step_mm apart (> 0; at least 2 along each axis).
/// If these would be more than 2^22 nodes, the distance is doubled until they are not.
TreMap tre_map(const PoseUncertainty& uncertainty, const VoxelGrid& ct, double step_mm);

}  // namespace nav::registration
