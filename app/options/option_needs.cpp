// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/option_needs.hpp"

namespace nav::app {

bool is_given(const CLI::App& verb, const char* option) {
  const CLI::Option* there = verb.get_option_no_throw(option);
  return there != nullptr && there->count() > 0;
}

Result<void> reject_idle(const CLI::App& verb, const std::vector<Need>& needs) {
  for (const Need& need : needs) {
    if (need.met) continue;
    for (const char* option : need.options) {
      if (!is_given(verb, option)) continue;
      return Error{ErrorCode::kUsage,
                   std::string(option) + " requires " + need.expected + ", found " + need.found};
    }
  }
  return {};
}

}  // namespace nav::app
