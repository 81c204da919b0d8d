// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/retired.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>

namespace nav::app {

void warn_retired(const std::string& name, const std::string& why) {
  std::fprintf(stderr, "sonde: warning: %s is no longer supported and is ignored: %s\n",
               name.c_str(), why.c_str());
}

void add_retired_option(CLI::App& verb, const std::string& option, const std::string& why) {
  verb.add_option_function<std::string>(
          option, [option, why](const std::string&) { warn_retired(option, why); })
      ->group("");
}

}  // namespace nav::app
