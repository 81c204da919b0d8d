// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/option_help.hpp"

#include <algorithm>
#include <sstream>

#include "app/options/option_checks.hpp"

namespace nav::app {
namespace {

constexpr std::size_t kLeftColumn = 30;
constexpr std::size_t kLineWidth = 100;

/// Words in lines of at most so many bytes.
std::vector<std::string> wrapped(const std::string& text, std::size_t width) {
  std::vector<std::string> lines(1);
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    std::string& line = lines.back();
    if (line.empty()) {
      line = word;
    } else if (line.size() + 1 + word.size() <= width) {
      line += " " + word;
    } else {
      lines.push_back(word);
    }
  }
  return lines;
}

/// Two columns; a long left text gets a line of its own.
std::string two_columns(const std::string& left, const std::string& right) {
  std::string text = "  " + left;
  if (text.size() + 2 > kLeftColumn) {
    text += "\n" + std::string(kLeftColumn, ' ');
  } else {
    text.resize(kLeftColumn, ' ');
  }
  const auto lines = wrapped(right, kLineWidth - kLeftColumn);
  for (std::size_t n = 0; n < lines.size(); ++n) {
    text += (n == 0 ? "" : std::string(kLeftColumn, ' ')) + lines[n] + "\n";
  }
  return text;
}

bool is_shown(const Option& option, bool all) {
  return option.retired.empty() && (all || option.usual || option.required);
}

/// Groups of a verb in the order of their first options.
std::vector<std::string> groups_of(const std::vector<const Option*>& options) {
  std::vector<std::string> groups;
  for (const Option* option : options) {
    if (std::ranges::count(groups, option->group) == 0) groups.push_back(option->group);
  }
  return groups;
}

std::string sentence(const Option& option, const Settings& defaults) {
  const std::string details = detail_text(option, defaults);
  return option.text + (details.empty() ? "" : " (" + details + ")");
}

}  // namespace

std::string usage_text(const Option& option) {
  if (is_argument(option) || is_flag(option)) return option.name;
  std::string text = option.name;
  const int values = std::max(1, count_of(option).fewest);
  for (int n = 0; n < values; ++n) text += " " + option.type;
  return text;
}

std::string detail_text(const Option& option, const Settings& defaults) {
  std::vector<std::string> parts;
  const std::string range = range_text(option);
  if (!range.empty()) {
    parts.push_back(range);
  } else if (!option.unit.empty()) {
    parts.push_back(option.unit);
  }
  const std::string value = is_flag(option) ? "" : value_text(option, defaults);
  const std::string standard = value.empty() ? option.absent : value;
  if (option.required) {
    parts.emplace_back("required");
  } else if (!standard.empty()) {
    parts.push_back("default: " + standard);
  }
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
  return text;
}

std::string verb_help(const Verb& verb, bool all) {
  const Settings defaults = default_settings(verb.name);
  const auto options = options_of(verb.name);
  std::string text = verb.summary + ".\n\nUsage: sonde " + verb.synopsis +
                     (options.empty() ? "\n" : " [options]\n");
  text += "\nExamples:\n";
  for (const std::string& example : verb.examples) text += "  " + example + "\n";
  std::size_t hidden = 0;
  for (const std::string& group : groups_of(options)) {
    std::string lines;
    for (const Option* option : options) {
      if (option->group != group || !option->retired.empty()) continue;
      if (is_shown(*option, all)) {
        lines += two_columns(usage_text(*option), sentence(*option, defaults));
      } else {
        ++hidden;
      }
    }
    if (!lines.empty()) text += "\n" + group + ":\n" + lines;
  }
  text += "\nHelp:\n" + two_columns("--help, --help-all", "print this help; also all options");
  text += two_columns("-v, --verbose", "also show information of the libraries");
  if (hidden > 0) {
    text += "\n" + std::to_string(hidden) + " more options: sonde " + verb.name + " --help-all\n";
  }
  return text;
}

std::string program_help(const std::vector<std::pair<std::string, std::string>>& verbs) {
  std::string text =
      "Sonde: live ultrasound inside the CT. Research software, not a medical device.\n\n"
      "Usage: sonde VERB [options]\n\nVerbs:\n";
  for (const auto& [name, summary] : verbs) text += two_columns(name, summary);
  text += "\nHelp:\n" + two_columns("sonde help VERB", "usual options of a verb, with examples");
  text += two_columns("sonde help VERB --help-all", "all options of a verb");
  text += two_columns("--version", "print the version");
  text += two_columns("-v, --verbose", "also show information of the libraries");
  return text;
}

}  // namespace nav::app
