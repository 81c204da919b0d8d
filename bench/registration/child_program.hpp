// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nav::bench {

/// What a program of its own process came to.
struct ProgramRun {
  double cpu_s;   ///< User and system time of the whole process.
  int exit_code;  ///< 0: it says that it succeeded.
};

/// Runs a program by its path with arguments, silently, and waits for it; absent when it could not
/// be run or was ended by a signal.
std::optional<ProgramRun> run_program(const std::vector<std::string>& words);

}  // namespace nav::bench
