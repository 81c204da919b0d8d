// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Texts that are generated from the tables of verbs and options.
#include <string>
#include <utility>
#include <vector>

#include "app/options/option.hpp"
#include "app/options/verb_table.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// The option as it is typed: "--width N", "--at X X X", "sweep".
std::string usage_text(const Option& option);

/// Range, unit and default: "16 to 8192 pixels; default 800". Empty: nothing to say.
std::string detail_text(const Option& option, const Settings& defaults);

/// Help of a verb: usage, examples, and options by group. all: also the options that are not usual.
std::string verb_help(const Verb& verb, bool all);

/// Help of the program. verbs: name and summary of each.
std::string program_help(const std::vector<std::pair<std::string, std::string>>& verbs);

/// Manual page of a verb, in troff.
std::string man_page(const Verb& verb);

/// Completion for bash. verbs: all names, also those without options in the table.
std::string bash_completion(const std::vector<std::string>& verbs);

/// Replaces the tables of a Markdown page. A table lies between the lines
/// `<!-- options of VERB -->`, `<!-- options: GROUP -->` or `<!-- keys of the session file -->` and
/// `<!-- end -->`. kMalformedData: a verb or group that does not exist, or a table without an end.
Result<std::string> with_tables(const std::string& page);

}  // namespace nav::app
