// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "app/console.hpp"
#include "io/json.hpp"
#include "nav/result.hpp"

namespace nav::app {

// The keys that `sonde info` prints for a file (docs/json.md, "info"). Findings go to the console.

/// Describes points and curves of 3D Slicer. Errors: those of io::read_markups().
Result<io::Json> describe_markups(const std::filesystem::path& path, Console& console);

/// Describes a transform file of ITK. Warns of one that places no CT, because it is not rigid.
/// Errors: those of io::read_ct_from_reference().
Result<io::Json> describe_transform(const std::filesystem::path& path, Console& console);

/// Describes a surface. Errors: those of io::read_surface().
Result<io::Json> describe_surface(const std::filesystem::path& path);

/// Describes a table of landmarks. Errors: those of read_landmarks().
Result<io::Json> describe_landmarks(const std::filesystem::path& path);

}  // namespace nav::app
