// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Describes a file: a tracked sequence, a CT (file or DICOM folder) or a PLUS configuration. json:
/// file for JSON with stable keys, "-" for standard output; absent: text on standard output.
Result<void> run_info(const std::filesystem::path& path, const std::optional<std::string>& json,
                      bool accept_unknown_orientation, Console& console);

}  // namespace nav::app
