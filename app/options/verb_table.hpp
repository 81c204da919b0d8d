// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nav::app {

/// One verb of the program whose options lie in the table of options.
struct Verb {
  std::string name;
  std::string summary;                ///< One line, a verb phrase.
  std::string synopsis;               ///< Most common use, without the program's name.
  std::vector<std::string> examples;  ///< Two complete command lines.
};

/// Every verb of the table, in the order of the help.
const std::vector<Verb>& verb_table();

/// Null: no verb of the table is called so.
const Verb* find_verb(std::string_view name);

}  // namespace nav::app
