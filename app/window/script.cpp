// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/script.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

namespace nav::app {

const std::vector<ScriptCommand>& script_commands() {
  static const std::vector<ScriptCommand> commands{
      {"click", 1, 1, "click CONTROL"},
      {"key", 1, 1, "key KEY, such as Space, F6, Ctrl+Q"},
      {"drag", 2, 4, "drag CONTROL DX DY [left, middle or right], drag histogram.NAME IMPORTANCE"},
      {"stroke", 3, 1000, "stroke VIEW show, hide or erase X,Y X,Y ..., mm from the cursor"},
      {"choose", 2, 2, "choose CONTROL ITEM"},
      {"set", 2, 2, "set CONTROL VALUE"},
      {"type", 1, 1000, "type CONTROL TEXT"},
      {"doubleclick", 1, 3, "doubleclick CONTROL [DX DY], pixels from its middle"},
      {"hover", 1, 1, "hover CONTROL"},
      {"wheel", 2, 3, "wheel CONTROL NOTCHES [ctrl]"},
      {"wait", 3, 3, "wait THING VALUE SECONDS"},
      {"expect", 2, 3, "expect THING VALUE [SECONDS]"},
      {"fault", 2, 2, "fault NAME SECONDS"},
      {"lengthen", 0, 0, "lengthen"},
      {"controls", 1, 1, "controls PAGE"},
      {"resize", 2, 2, "resize WIDTH HEIGHT"},
      {"pause", 1, 1, "pause SECONDS"},
      {"shot", 1, 1, "shot NAME"},
      {"quit", 0, 0, "quit"}};
  return commands;
}

Result<std::vector<ScriptLine>> parse_script(std::string_view text) {
  constexpr std::size_t kMostLines = 100000;
  std::vector<ScriptLine> lines;
  std::istringstream stream{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::istringstream words(line);
    ScriptLine made{.number = number, .command = {}, .words = {}};
    if (!(words >> made.command) || made.command.front() == '#') continue;
    for (std::string word; words >> word;) made.words.push_back(word);
    const std::string where = "line " + std::to_string(number) + ": ";
    const auto& commands = script_commands();
    const auto known = std::ranges::find_if(
        commands, [&](const ScriptCommand& command) { return made.command == command.name; });
    if (known == commands.end()) {
      std::string names;
      for (const ScriptCommand& command : commands) {
        names += (names.empty() ? "" : ", ") + std::string(command.name);
      }
      return Error{ErrorCode::kUsage,
                   where + "expected one of " + names + ", found '" + made.command + "'"};
    }
    const auto count = static_cast<int>(made.words.size());
    if (count < known->fewest || count > known->most) {
      return Error{ErrorCode::kUsage, where + "expected '" + known->usage + "', found " +
                                          std::to_string(count) + " words after it"};
    }
    lines.push_back(std::move(made));
    if (lines.size() > kMostLines) {
      return Error{ErrorCode::kUsage, where + "expected at most " + std::to_string(kMostLines) +
                                          " commands, found more"};
    }
  }
  return lines;
}

Result<double> script_number(const std::string& word, double low, double high) {
  double value = 0;
  const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error == std::errc() && stop == end && std::isfinite(value) && value >= low &&
      value <= high) {
    return value;
  }
  std::ostringstream text;
  text << "expected a number of " << low << " to " << high << ", found '" << word << "'";
  return Error{ErrorCode::kUsage, text.str()};
}

}  // namespace nav::app
