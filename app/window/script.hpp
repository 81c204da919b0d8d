// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nav/result.hpp"

namespace nav::app {

/// One line of a script: a command and its words.
struct ScriptLine {
  int number = 0;  ///< In the file, from 1.
  std::string command;
  std::vector<std::string> words;
};

/// Commands of scripts, with the least and the most words after them.
struct ScriptCommand {
  const char* name;
  int fewest, most;
  const char* usage;
};
const std::vector<ScriptCommand>& script_commands();

/// Reads a script: one command a line; empty lines and lines that begin with # do nothing. kUsage
/// with line, what was expected and what was found.
Result<std::vector<ScriptLine>> parse_script(std::string_view text);

/// Number of a word. kUsage: it is none, or not in [low, high].
Result<double> script_number(const std::string& word, double low, double high);

}  // namespace nav::app
