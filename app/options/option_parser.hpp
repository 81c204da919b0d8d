// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "app/options/option.hpp"
#include "app/options/option_needs.hpp"

namespace nav::app {

/// Adds the options of a verb to its parser. They store into \p settings, which outlives it.
void add_options(CLI::App& parser, std::string_view verb, Settings& settings);

/// Adds one option. It stores into \p settings; both outlive the parser.
void add_option(CLI::App& parser, const Option& option, Settings& settings);

/// Rejects the first option of a verb that was given and would have no effect, because something
/// that it needs is not there or another setting replaces it. Values of a session file count as
/// there, but its own keys are not rejected: a resolved file holds all of them. kUsage.
Result<void> reject_idle(const CLI::App& parser, std::string_view verb, const Settings& settings);

/// An error of a check that names a key of the session file, by the option that set the key: where
/// one was given, "--width (output.width_px): expected …, found …". Other errors pass unchanged.
Result<void> as_given(const CLI::App& parser, std::string_view verb, Result<void> checked);

/// One line for each option that was given by an older name: "--old is now called --new".
std::vector<std::string> renamed_options(const std::vector<const Option*>& options,
                                         const std::vector<std::string>& arguments);

}  // namespace nav::app
