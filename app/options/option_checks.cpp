// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/option_checks.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <sstream>

#include "app/options/option.hpp"

namespace nav::app {
namespace {

/// The verb that was meant, or its part: the last that the parser came to.
const CLI::App& meant_verb(const CLI::App& app) {
  const CLI::App* verb = &app;
  while (!verb->get_subcommands().empty()) verb = verb->get_subcommands().front();
  return *verb;
}

/// "sonde info".
std::string full_name(const CLI::App& verb) {
  // The parser has the name of a program from its command line.
  if (verb.get_parent() == nullptr) return std::filesystem::path(verb.get_name()).filename();
  return full_name(*verb.get_parent()) + " " + verb.get_name();
}

/// Null: no option is called so.
const CLI::Option* find_option(const CLI::App& app, const std::string& name) {
  for (const CLI::App* verb = &meant_verb(app); verb != nullptr; verb = verb->get_parent()) {
    if (const CLI::Option* option = verb->get_option_no_throw(name)) return option;
  }
  return nullptr;
}

/// "a whole number", "3 numbers".
std::string kind_of(const CLI::Option& option) {
  const std::string described = option.get_type_name();
  const std::string type = described.substr(0, described.find(':'));
  const auto among = [&](std::initializer_list<const char*> types) {
    return std::ranges::any_of(types, [&](const char* one) { return type == one; });
  };
  const bool whole = type.find("INT") != std::string::npos || type == "N";
  const bool number = type.find("FLOAT") != std::string::npos ||
                      among({"X", "MM", "DEG", "HU", "MS", "S", "HZ", "PPM", "MM/S"});
  const std::string noun = whole ? "whole number" : number ? "number" : "value";
  const int count = option.get_items_expected_min();
  if (count == 0) return "true or false";
  return count == 1 ? "a " + noun : std::to_string(count) + " " + noun + "s";
}

/// Message about a value that was not given, with the help text of the option.
std::string nothing_for(const CLI::Option& option) {
  const std::string& description = option.get_description();
  const std::size_t given = option.results().size();
  return option.get_name() + ": expected " + kind_of(option) +
         (description.empty() ? "" : " (" + description + ")") + ", found " +
         (given == 0 ? "none" : std::to_string(given));
}

/// Message about a value that is not of the option's kind, or a whole number that is too large to
/// be held.
std::string not_converted(const CLI::Option& option) {
  std::string expected = kind_of(option);
  std::string found;
  for (const std::string& text : option.results()) found += (found.empty() ? "" : " ") + text;
  std::int64_t number = 0;
  const char* const end = found.data() + found.size();
  const auto read = std::from_chars(found.data(), end, number);
  if (expected == "a whole number" && read.ptr == end && !found.empty()) {
    using Limits = std::numeric_limits<int>;
    expected += " of " + std::to_string(Limits::min()) + " to " + std::to_string(Limits::max());
  }
  return option.get_name() + ": expected " + expected + ", found " + found;
}

std::string wrong_count(const CLI::Option& option) {
  const std::size_t given = option.results().size();
  if (given < static_cast<std::size_t>(option.get_items_expected_min())) return nothing_for(option);
  return option.get_name() + ": expected it once, with " + kind_of(option) + ", found " +
         std::to_string(given) + " values";
}

/// Fewest letters to insert, leave out, replace or swap with the next, to make one word the other.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> steps(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        steps[i][j] = i + j;
        continue;
      }
      const std::size_t replaced = steps[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      steps[i][j] = std::min({replaced, steps[i - 1][j] + 1, steps[i][j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        steps[i][j] = std::min(steps[i][j], steps[i - 2][j - 2] + 1);
      }
    }
  }
  return steps[a.size()][b.size()];
}

/// "; did you mean --width?", or nothing where no name is close.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& names) {
  const std::size_t most = word.size() < 6 ? 1 : 2;
  std::string closest;
  std::size_t least = most + 1;
  for (const std::string& name : names) {
    const std::size_t distance = edit_distance(word, name);
    if (distance < least) closest = name;
    least = std::min(least, distance);
  }
  return closest.empty() ? "" : "; did you mean " + closest + "?";
}

std::string wrong_verb(const CLI::App& app) {
  const CLI::App& verb = meant_verb(app);
  std::vector<std::string> names;
  for (const CLI::App* one : verb.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(one->get_name());
  }
  const auto rest = app.remaining(true);
  const std::string name = full_name(verb);
  const bool first = name.find(' ') == std::string::npos;
  return (first ? "verb" : name) + ": expected one of " + listed(names) + ", found " +
         (rest.empty() ? "none" : "'" + rest.front() + "'" + did_you_mean(rest.front(), names));
}

std::string wrong_argument(const CLI::App& app) {
  const std::string name = full_name(meant_verb(app));
  const auto rest = app.remaining(true);
  const std::string found = rest.empty() ? "others" : rest.front();
  const bool option = found.starts_with('-');
  const bool all = option && meant_verb(app).get_help_all_ptr() != nullptr;
  const std::string word = found.substr(0, found.find('='));
  std::vector<std::string> names;
  for (const CLI::Option* one : meant_verb(app).get_options()) names.push_back(one->get_name());
  return name + ": expected " + (option ? "an option that" : "no further argument than") + " '" +
         name + (all ? " --help-all" : " --help") + "' lists, found " + found +
         (option ? did_you_mean(word, names) : "");
}

}  // namespace

CLI::Validator in_range(double low, double high, const std::string& unit) {
  std::ostringstream range;
  range.precision(12);
  range << low << " to " << high << (unit.empty() ? "" : " ") << unit;
  const auto reject = [low, high, expected = range.str()](const std::string& text) -> std::string {
    double number = 0;
    const bool read = CLI::detail::lexical_cast(text, number);
    return read && number >= low && number <= high ? ""
                                                   : "expected " + expected + ", found " + text;
  };
  return {reject, range.str()};
}

CLI::Validator among(const std::vector<std::string>& names) {
  const auto reject = [names](const std::string& text) -> std::string {
    const bool known = std::find(names.begin(), names.end(), text) != names.end();
    return known ? "" : "expected " + listed(names) + ", found " + text;
  };
  return {reject, listed(names)};
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t n = 0; n < names.size(); ++n) {
    text += (n == 0 ? "" : n + 1 < names.size() ? ", " : " or ") + names[n];
  }
  return text;
}

std::string in_words(const CLI::App& app, const CLI::ParseError& problem) {
  // The parser tells of the option by its name only, somewhere in its text.
  const std::string said = problem.what();
  const auto option_at = [&](std::size_t begin) {
    return find_option(app, said.substr(begin, said.find_first_of(": ", begin) - begin));
  };
  if (dynamic_cast<const CLI::ConversionError*>(&problem) != nullptr) {
    const auto colon = said.find(": ");
    const auto* option = colon == std::string::npos ? nullptr : option_at(colon + 2);
    if (option != nullptr) return not_converted(*option);
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&problem) != nullptr) {
    if (const auto* option = option_at(0)) return wrong_count(*option);
  }
  if (dynamic_cast<const CLI::RequiredError*>(&problem) != nullptr) {
    const auto* option = option_at(0);
    if (option == nullptr) return wrong_verb(app);
    // A mistyped option is likely the cause of the one that is missing.
    const auto rest = app.remaining(true);
    const bool mistyped = !rest.empty() && rest.front().starts_with('-');
    return mistyped ? wrong_argument(app) : nothing_for(*option);
  }
  if (dynamic_cast<const CLI::ExcludesError*>(&problem) != nullptr) {
    const std::string excludes = " excludes ";
    const auto at = said.find(excludes);
    return said.substr(0, at) + " cannot be combined with " + said.substr(at + excludes.size());
  }
  if (dynamic_cast<const CLI::ExtrasError*>(&problem) != nullptr) return wrong_argument(app);
  return said;
}

Result<void> reject_empty(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    const auto& given = option->results();
    const std::string name = option->get_name();
    const Option* row = find_option_of(app.get_name(), name);
    const bool may_be = row != nullptr && row->may_be_empty;
    if (may_be || std::ranges::find(given, "") == given.end()) continue;
    return Error{ErrorCode::kUsage, name + ": expected " + kind_of(*option) + ", found ''"};
  }
  for (const CLI::App* verb : app.get_subcommands()) {
    if (auto ok = reject_empty(*verb); !ok) return ok;
  }
  return {};
}

}  // namespace nav::app
