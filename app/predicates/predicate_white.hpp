// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "nav/diagnostics.hpp"

namespace nav::app {

/// Warns when more than 5 % of the known voxels of a volume lie above white, because these voxels
/// all look equal. The warning gives their share, the greatest value, and a white that leaves 1 %
/// above it. name: of the volume.
void warn_of_white(const std::string& name, std::span<const std::int16_t> voxels, double white,
                   const std::optional<int>& unknown, Diagnostics& diagnostics);

}  // namespace nav::app
