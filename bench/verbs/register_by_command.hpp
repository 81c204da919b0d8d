// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "bench/registration/peer.hpp"
#include "nav/result.hpp"

namespace nav::bench {

/// Writes the sweep as a recording into the folder and registers it to the CT's file by the program
/// sonde that lies beside this one, with one thread: the time that a user's command takes from
/// files to the report.
Result<CommandRun> register_by_command(const Sweep& sweep, const std::filesystem::path& ct,
                                       const CtPose& start, registration::Effort effort,
                                       const std::filesystem::path& folder);

}  // namespace nav::bench
