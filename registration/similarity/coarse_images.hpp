// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/sweep.hpp"

namespace nav::registration {

/// Width of the averaged blocks, in sigmas: averaging blocks this wide first removes little that a
/// Gaussian would keep.
inline constexpr double kBlockPerSigma = 0.85;
inline constexpr int kMostPixelsPerBlock = 64;

/// Mean grey, rounded, of blocks of factor × factor pixels; leftover pixels at the right and at the
/// bottom are cut off. The pixel grid of the result gives the centres of the blocks. Precondition:
/// factor is 1 to kMostPixelsPerBlock and not larger than the image.
UltrasoundImage averaged(const UltrasoundImage& frame, int factor);

/// Side of the blocks, in pixels, that may be averaged if the image is smoothed with sigma_mm
/// afterwards, 1 to kMostPixelsPerBlock.
int pixels_per_block(const PixelGrid& grid, int width, int height, double sigma_mm);

/// At most \p most ultrasound images, spread evenly along the path of their corners, averaged over
/// blocks as sigma_mm allows. Precondition: most >= 1.
Sweep coarse_images(const Sweep& sweep, int most, double sigma_mm);

}  // namespace nav::registration
