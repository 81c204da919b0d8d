// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nav::bench {

/// Result of a program in its own process.
struct ProgramRun {
  double cpu_s;   ///< User and system time of the whole process.
  int exit_code;  ///< 0: success.
};

/// Runs a program by its path with arguments, without output, and waits for it; absent if it could
/// not be run or was ended by a signal.
std::optional<ProgramRun> run_program(const std::vector<std::string>& words);

}  // namespace nav::bench
