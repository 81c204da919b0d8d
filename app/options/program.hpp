// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "nav/result.hpp"

namespace nav::app {

/// Prints an error of a program as one line on standard error, "sonde: error: …". Returns the exit
/// code that it deserves.
int print_error(const std::string& program, const Error& error);

/// Runs the body of a program and returns its exit code. An exception that the body throws becomes
/// one line on standard error and the exit code of exhausted memory or of a bug.
int run_guarded(const std::string& program, const std::function<int()>& body);

}  // namespace nav::app
