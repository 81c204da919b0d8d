// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "app/predicate_options.hpp"
#include "nav/diagnostics.hpp"

namespace nav::app {

/// Warns where more than 5 % of the known voxels of a volume lie above the white of the options:
/// they are all drawn alike. Says how many they are, the greatest, and a white that leaves 1 %
/// above it. name: of the volume.
void warn_of_white(const std::string& name, std::span<const std::int16_t> voxels,
                   const PredicateOptions& options, Diagnostics& diagnostics);

}  // namespace nav::app
