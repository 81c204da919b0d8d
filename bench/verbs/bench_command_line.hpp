// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav::bench {

/// The program sonde-bench: parses the command line, runs the verb and returns its exit code, one
/// of those of `sonde`. Errors go to standard error as one line.
int run_command_line(int argc, const char* const* argv);

}  // namespace nav::bench
