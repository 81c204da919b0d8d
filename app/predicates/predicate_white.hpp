// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "nav/diagnostics.hpp"

namespace nav::app {

/// Stored values that are drawn black and white.
struct IntensityWindow {
  double black = 0;
  double white = 255;
  bool by_percentiles = false;
};

/// Window of a volume for which none is given. Percentiles are those of the known voxels above
/// their least value, because that value fills the outside of sectors. 0 and 255 where the 99.5th
/// lies from 128 to 255 and the first from 0 to 64; otherwise (dim and bright volumes, more than 8
/// bits) the first and the 99.5th percentile. Volumes of one value have 0 and 255.
IntensityWindow intensity_window(std::span<const std::int16_t> voxels,
                                 const std::optional<int>& unknown);

/// Warns when more than 5 % of the known voxels of a volume lie above white, because these voxels
/// all look equal. The warning gives their share, the greatest value, and a white that leaves 1 %
/// above it. name: of the volume.
void warn_of_white(const std::string& name, std::span<const std::int16_t> voxels, double white,
                   const std::optional<int>& unknown, Diagnostics& diagnostics);

}  // namespace nav::app
