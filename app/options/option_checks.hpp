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

// What an option may be. Each refuses as `expected …, found …`, to which the parser adds the name;
// the parser's own checks say it in other words. Each describes itself in the help.

/// Of a seed: 0 to 2^64 - 1.
CLI::Validator whole_number();

/// low to high, ends included. unit, such as "pixels", may be empty.
CLI::Validator in_range(double low, double high, const std::string& unit = "");

/// Any number: its range is checked with the other options. expected: that range, in words.
CLI::Validator number_of(const std::string& expected);

/// One of these names.
CLI::Validator among(const std::vector<std::string>& names);

/// What a `..._from(name)` takes, or, where it is not empty, another name. That function refuses
/// with "thing: expected A, B or C, found D".
template <class From>
CLI::Validator taken_by(From from, const std::string& or_else = "");

/// An option whose value is one of some, by name.
template <class T>
CLI::Option* add_choice(CLI::App& verb, const std::string& option, T& value,
                        const std::map<std::string, T>& choices, const std::string& description);

/// "a, b or c".
std::string listed(const std::vector<std::string>& names);

/// What is wrong with a command line that app could not parse: the option or verb, what was
/// expected and what was found. One sentence.
std::string in_words(const CLI::App& app, const CLI::ParseError& problem);

/// Refuses options of a parsed command line that were given an empty value, for which a variable
/// stood that was never set. Only --needle-frame means something by it: that there is none.
Result<void> refuse_empty(const CLI::App& app);

// Implementation.

/// A refusal by another part of Sonde, as that of an option that may also be or_else.
std::string as_of_option(const std::string& refusal, const std::string& or_else);

template <class From>
CLI::Validator taken_by(From from, const std::string& or_else) {
  const auto refuse = [from, or_else](const std::string& text) -> std::string {
    if (!or_else.empty() && text == or_else) return "";
    const auto taken = from(text);
    return taken ? "" : as_of_option(taken.error().message, or_else);
  };
  return {refuse, ""};
}

template <class T>
CLI::Option* add_choice(CLI::App& verb, const std::string& option, T& value,
                        const std::map<std::string, T>& choices, const std::string& description) {
  std::vector<std::string> names;
  for (const auto& [name, choice] : choices) names.push_back(name);
  const auto take = [&value, choices](const std::string& name) { value = choices.at(name); };
  return verb.add_option_function<std::string>(option, take, description)->check(among(names));
}

}  // namespace nav::app
