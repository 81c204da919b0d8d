// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/console.hpp"
#include "app/options/settings.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Shows the window until it is closed, its script has ended, or Ctrl-C. \p argc, \p argv: of the
/// program; Qt takes its own options from them. Errors: kUnavailable without a display, kRefused
/// for a line of a script that cannot be done, and those of the files that the options name.
Result<void> run_window(const Settings& settings, int& argc, char** argv, Console& console);

}  // namespace nav::app
