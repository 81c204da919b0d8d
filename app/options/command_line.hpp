// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav::app {

/// The program: parses the command line, runs the verb, returns its exit code. Errors go to
/// standard error as one line.
int run_command_line(int argc, const char* const* argv);

}  // namespace nav::app
