// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "nav/result.hpp"

namespace nav::app {

struct ExportOptions {
  std::filesystem::path out;  ///< PLUS sequence to write, .mha or .nrrd.
  bool compress = false;
};

/// Writes the recording of a session as a PLUS sequence: each image with the poses of the probe,
/// the reference and the needle at its time, and ImageToProbe. Poses are those after clock models,
/// gate and interpolation, because a frame of PLUS has one time; a pose that is missing then has
/// the status INVALID. Images of another size than the first are left out, with a warning. If an
/// image has colours, all are written as RGB; a pipe whose first image is grey is written in grey,
/// with a warning.
Result<void> run_export(const SessionConfig& config, const ExportOptions& options,
                        Console& console);

}  // namespace nav::app
