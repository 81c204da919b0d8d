// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/sweep.hpp"

namespace nav::registration {

/// Averaging blocks of so many sigmas first changes little that a Gaussian would keep.
inline constexpr double kBlockPerSigma = 0.85;
inline constexpr int kMostPixelsPerBlock = 64;

/// Mean grey, rounded, of blocks of factor × factor pixels; what is left over at the right and at
/// the bottom is cut off. The pixel grid says where the blocks' middles lie. Precondition: factor
/// from 1 to kMostPixelsPerBlock, no larger than the picture.
UltrasoundFrame averaged(const UltrasoundFrame& frame, int factor);

/// How many pixels along a side may be one where a picture is smoothed with sigma_mm afterwards, 1
/// to kMostPixelsPerBlock.
int pixels_per_block(const PixelGrid& grid, int width, int height, double sigma_mm);

/// At most so many pictures, evenly along the way of their corners, averaged over blocks as
/// sigma_mm allows. Precondition: most >= 1.
Sweep coarse_pictures(const Sweep& sweep, int most, double sigma_mm);

}  // namespace nav::registration
