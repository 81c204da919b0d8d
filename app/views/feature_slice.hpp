// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nav/image.hpp"
#include "render/features/volume.hpp"

namespace nav::app {

/// Grey values and words of a slice of a feature.
struct FeatureSliceOptions {
  render::features::ValueRange range{};  ///< low is black, high is white.
  std::string title{};                   ///< "snr across i".
  std::string range_words{};             ///< "0.1 to 2.3 white/mm", the values of black and white.
  int size_px = 512;                     ///< Longer side of the image, [64, 8192].
};

/// Image of the middle slice across an axis (0, 1, 2) of a feature, the nearest voxel in each
/// pixel, pixels square in mm; undefined values are dark blue. With letters at all four edges,
/// name, scale bar, position and range, where the shorter side has at least 128 pixels.
Image2d<Rgba8> feature_slice(const render::features::FeatureVolume& volume, int axis,
                             const FeatureSliceOptions& options);

}  // namespace nav::app
