// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <iostream>

#include "app/options/exit_code.hpp"
#include "app/options/option_checks.hpp"
#include "app/options/option_help.hpp"
#include "app/options/option_parser.hpp"
#include "app/options/program.hpp"
#include "app/window/window_program.hpp"

namespace nav::app {
namespace {

int window_main(int argc, char** argv) {
  CLI::App parser("The window of Sonde");
  Settings settings = default_settings("window");
  add_options(parser, "window", settings);
  try {
    parser.parse(argc, argv);
  } catch (const CLI::Success&) {
    std::cout << verb_help(*find_verb("window"), true) << std::flush;
    return kExitOk;
  } catch (const CLI::ParseError& problem) {
    return print_error("sonde-window", {ErrorCode::kUsage, in_words(parser, problem)});
  }
  if (const auto ok = reject_empty(parser); !ok) return print_error("sonde-window", ok.error());
  if (const auto ok = reject_idle(parser, "window", settings); !ok) {
    return print_error("sonde-window", ok.error());
  }
  Console console(false);
  // Qt reads the rest of its options from the environment.
  int one = 1;
  const auto shown = run_window(settings, one, argv, console);
  return shown ? kExitOk : print_error("sonde-window", shown.error());
}

}  // namespace
}  // namespace nav::app

int main(int argc, char** argv) {
  return nav::app::run_guarded("sonde-window", [&] { return nav::app::window_main(argc, argv); });
}
