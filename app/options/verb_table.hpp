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

/// Verbs without options in the table: help and completion, and those of the program sonde-bench.
const std::vector<Verb>& other_verbs();

/// A verb of either kind. Null: none is called so.
const Verb* find_verb(std::string_view name);

}  // namespace nav::app
