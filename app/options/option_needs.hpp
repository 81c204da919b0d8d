// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::app {

/// A condition that some options need to have an effect.
struct Need {
  std::vector<const char*> options;
  bool met;
  std::string expected;
  std::string found = "none";
};

/// Tells whether an option was given. False for options that the verb does not have.
bool is_given(const CLI::App& verb, const char* option);

/// Rejects, by name, the first given option whose need is not met (kUsage).
Result<void> reject_idle(const CLI::App& verb, const std::vector<Need>& needs);

}  // namespace nav::app
