// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::app {

/// Words of the command line of sonde-bench that do what `sonde bench …` or `sonde gallery …` asks
/// for; absent for other verbs. The first word is the name by which sonde-bench calls itself in
/// messages: "sonde bench", or "sonde" of "sonde gallery".
std::optional<std::vector<std::string>> bench_words(int argc, const char* const* argv);

/// Replaces this process by the program sonde-bench with these words: the one beside this
/// program's file, otherwise the one in the PATH. Returns only if that fails: kUnavailable.
Error run_bench_program(const std::vector<std::string>& words);

}  // namespace nav::app
