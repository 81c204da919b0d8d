// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/option_parser.hpp"

#include <algorithm>

#include "app/options/option_checks.hpp"
#include "app/options/retired.hpp"

namespace nav::app {
namespace {

/// "--needle straight, bevel or tip-load".
std::string condition_text(const Condition& condition) {
  return condition.option + (condition.values.empty() ? "" : " " + listed(condition.values));
}

std::string conditions_text(const std::vector<Condition>& conditions) {
  std::vector<std::string> texts;
  for (const Condition& condition : conditions) texts.push_back(condition_text(condition));
  return listed(texts);
}

/// Options that only some verbs have hold nowhere else.
struct Asked {
  const CLI::App& parser;
  std::string_view verb;
  const Settings& settings;

  bool holds(const Condition& condition) const {
    const Option* option = find_option_of(verb, condition.option);
    if (option == nullptr) return false;
    if (condition.values.empty()) {
      return is_set(*option, settings) || (option->take != nullptr && given(*option));
    }
    return std::ranges::count(condition.values, value_text(*option, settings)) > 0;
  }
  bool given(const Option& option) const { return is_given(parser, option.name.c_str()); }
  bool holds(const Requirement& need) const {
    if (!need.verb.empty() && need.verb != verb) return true;
    if (need.met != nullptr) return need.met(settings);
    return std::ranges::any_of(need.any_of, [&](const Condition& one) { return holds(one); });
  }
  /// The value that is there instead of the one that is needed; empty: not worth saying.
  std::string found(const Requirement& need) const {
    if (need.found != nullptr) return need.found(settings);
    if (need.any_of.size() != 1 || need.any_of.front().values.empty()) return "";
    const Option* option = find_option_of(verb, need.any_of.front().option);
    return option == nullptr ? "" : value_text(*option, settings);
  }
};

}  // namespace

void add_option(CLI::App& parser, const Option& option, Settings& settings) {
  if (!option.retired.empty()) return add_retired_option(parser, option.name, option.retired);
  const auto store = [&option, &settings](const CLI::results_t& values) {
    if (const auto ok = take(option, values, settings); !ok) {
      throw CLI::ValidationError(ok.error().message);
    }
    return true;
  };
  const std::string names = option.name + (option.formerly.empty() ? "" : "," + option.formerly);
  CLI::Option* added = parser.add_option(names, store, option.text);
  if (is_flag(option)) {
    added->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)->expected(0);
    return;
  }
  added->type_name(option.type);
  const Count count = count_of(option);
  added->expected(count.most < 0 ? CLI::detail::expected_max_vector_size : count.most);
  if (option.delimiter != '\0') added->delimiter(option.delimiter);
  if (option.required) added->required();
  if (option.in_order) added->trigger_on_parse();
}

void add_options(CLI::App& parser, std::string_view verb, Settings& settings) {
  const auto options = options_of(verb);
  for (const Option* option : options) add_option(parser, *option, settings);
  for (const Option* option : options) {
    for (const std::string& other : option->excludes) {
      if (CLI::Option* there = parser.get_option_no_throw(other)) {
        parser.get_option(option->name)->excludes(there);
      }
    }
  }
}

Result<void> reject_idle(const CLI::App& parser, std::string_view verb, const Settings& settings) {
  const Asked asked{parser, verb, settings};
  for (const Option* option : options_of(verb)) {
    if (!asked.given(*option)) continue;
    for (const Requirement& need : option->needs) {
      if (asked.holds(need)) continue;
      const std::string found = asked.found(need);
      return Error{ErrorCode::kUsage,
                   option->name + " requires " +
                       (need.text.empty() ? conditions_text(need.any_of) : need.text) +
                       (found.empty() ? "" : " (found " + found + ")")};
    }
    for (const Condition& condition : option->idle_with) {
      if (!asked.holds(condition)) continue;
      return Error{ErrorCode::kUsage,
                   option->name + " has no effect with " + condition_text(condition)};
    }
  }
  return {};
}

Result<void> as_given(const CLI::App& parser, std::string_view verb, Result<void> checked) {
  if (checked) return checked;
  const Error& said = checked.error();
  for (const Option* option : options_of(verb)) {
    if (!is_given(parser, option->name.c_str())) continue;
    std::vector<std::string> keys = option->more_keys;
    if (!option->key.empty()) keys.insert(keys.begin(), option->key);
    for (const std::string& key : keys) {
      if (!said.message.starts_with(key + ":")) continue;
      return Error{said.code, option->name + " (" + key + ")" + said.message.substr(key.size())};
    }
  }
  return checked;
}

std::vector<std::string> renamed_options(const std::vector<const Option*>& options,
                                         const std::vector<std::string>& arguments) {
  std::vector<std::string> lines;
  for (const Option* option : options) {
    if (option->formerly.empty()) continue;
    const bool used = std::ranges::any_of(arguments, [&](const std::string& argument) {
      return argument == option->formerly || argument.starts_with(option->formerly + "=");
    });
    if (used) lines.push_back(option->formerly + " is now called " + option->name);
  }
  return lines;
}

}  // namespace nav::app
