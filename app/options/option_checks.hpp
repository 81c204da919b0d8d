// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::app {

// Checks of values. Each rejects with `expected …, found …`, to which the parser adds the name; the
// parser's own checks have other texts. Each describes itself in the help.

/// low to high, ends included. unit, such as "pixels", may be empty.
CLI::Validator in_range(double low, double high, const std::string& unit = "");

/// One of these names.
CLI::Validator among(const std::vector<std::string>& names);

/// An option whose value is one of some, by name.
template <class T>
CLI::Option* add_choice(CLI::App& verb, const std::string& option, T& value,
                        const std::map<std::string, T>& choices, const std::string& description);

/// "a, b or c".
std::string listed(const std::vector<std::string>& names);

/// Message about a command line that app could not parse: the option or verb, what was
/// expected and what was found. One sentence.
std::string in_words(const CLI::App& app, const CLI::ParseError& problem);

/// Rejects options of a parsed command line that were given an empty value, for which a variable
/// stood that was never set, unless the table says that an empty value has a meaning.
Result<void> reject_empty(const CLI::App& app);

// Implementation.

template <class T>
CLI::Option* add_choice(CLI::App& verb, const std::string& option, T& value,
                        const std::map<std::string, T>& choices, const std::string& description) {
  std::vector<std::string> names;
  for (const auto& [name, choice] : choices) names.push_back(name);
  const auto take = [&value, choices](const std::string& name) { value = choices.at(name); };
  return verb.add_option_function<std::string>(option, take, description)->check(among(names));
}

}  // namespace nav::app
