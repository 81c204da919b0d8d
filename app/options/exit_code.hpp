// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"

namespace nav::app {

/// Exit codes of the program, documented in docs/command-line.md.
inline constexpr int kExitOk = 0;
inline constexpr int kExitBug = 1;
inline constexpr int kExitUsage = 2;
inline constexpr int kExitBadInput = 3;
inline constexpr int kExitDevice = 4;
inline constexpr int kExitRefused = 5;

/// The exit code that an error deserves.
int exit_code(const Error& error);

}  // namespace nav::app
