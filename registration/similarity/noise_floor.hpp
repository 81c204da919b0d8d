// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace nav::registration {

/// Mean grey of each cell of an image, depth-major: depth * lines + line; negative: no pixel.
using CellGreys = std::vector<float>;

/// Scan lines and depth bins of all images of a sweep.
struct CellCount {
  int lines = 0, depths = 0;
};

/// The grey of electronic noise in a sweep, by depth. The depth gain lifts noise until it is as
/// bright as tissue, so that no fixed grey tells them apart.
struct NoiseFloor {
  /// First depth bin from which on all images show noise alone; depths: none.
  int noise_from = 0;
  /// Least grey of an echo, by depth, for cells that calm() has averaged. 0: noise and tissue
  /// cannot be told apart there, or there is no noise.
  std::vector<float> least_echo;
};

/// Averages each cell over 5 depth bins and 3 lines, which calms speckle and noise. Cells without a
/// pixel stay so and do not count.
CellGreys calm(const CellGreys& greys, CellCount count);

/// Estimates the noise of a sweep from its images. A shadow holds noise alone, and the depth gain
/// rises with depth: so noise is no brighter than the darkest cells at its depth or any depth
/// below. Its spread is that of these cells. Noise differs from tissue in that a line tells nothing
/// about another line 5 mm beside it. greys: cells of each image about 1 mm apart; calmed: the same
/// after calm(). Deterministic.
NoiseFloor noise_floor(const std::vector<CellGreys>& greys, const std::vector<CellGreys>& calmed,
                       CellCount count);

}  // namespace nav::registration
