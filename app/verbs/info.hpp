// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Says what a file is: a tracked sequence, a CT (file or DICOM folder), or a PLUS configuration.
/// Human-readable on standard output, or JSON with stable keys where json says ("-": standard
/// output).
Result<void> run_info(const std::filesystem::path& path, const std::optional<std::string>& json,
                      bool accept_unknown_orientation, Console& console);

}  // namespace nav::app
