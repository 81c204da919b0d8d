// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/command_line.hpp"

#include <iostream>
#include <utility>

#include "app/options/exit_code.hpp"
#include "app/options/option_checks.hpp"
#include "app/options/option_parser.hpp"
#include "app/options/overwriting.hpp"
#include "app/options/program.hpp"
#include "app/options/verbs.hpp"
#include "app/verbs/bench_program.hpp"
#include "app/verbs/devices.hpp"
#include "app/verbs/info.hpp"

namespace nav::app {

Result<void> print_session(const SessionConfig& config) {
  const auto text = to_toml(config);
  if (!text) return text.error();
  std::cout << *text;
  return {};
}

void CommandLine::add_info() {
  CLI::App& verb = add_verb("info", settings_);
  verb.callback([this] {
    verb_ = [this](Console& console) -> Result<void> {
      const std::vector<NamedFile> inputs{{"file", settings_.file}};
      if (auto ok = refuse_overwriting({{"--json", settings_.json}}, inputs); !ok) return ok;
      return run_info(settings_.file, json(), settings_.config.ct.accept_unknown_orientation,
                      console);
    };
  });
}

void CommandLine::add_bench_program() {
  for (const auto& [name, description] :
       {std::pair{"bench", "Measure run time against error (program sonde-bench)"},
        {"gallery", "Draw the pictures of docs/gallery.md (program sonde-bench)"}}) {
    CLI::App* verb = app_.add_subcommand(name, description);
    // run() hands the command line over before it is parsed.
    verb->callback([this, name = std::string(name)] {
      verb_ = [name](Console&) -> Result<void> {
        return Error{ErrorCode::kUsage, name + ": expected it as the first word, found others"};
      };
    });
  }
}

void CommandLine::add_devices() {
  add_verb("devices", settings_).callback([this] {
    verb_ = [this](Console& console) { return run_devices(json(), console); };
  });
}

int CommandLine::fail(const Error& error) const { return print_error("sonde", error); }

int CommandLine::run(int argc, const char* const* argv) {
  if (const auto words = bench_words(argc, argv)) return fail(run_bench_program(*words));
  // Options win over the session file, so it is read before they are.
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    std::string file;
    if (argument == "--session" && i + 1 < argc) file = argv[i + 1];
    if (argument.starts_with("--session=")) file = argument.substr(10);
    if (file.empty()) continue;
    auto config = read_session_config(file);
    if (!config) return fail(config.error());
    settings_.config = std::move(*config);
  }
  try {
    app_.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return app_.exit(success);
  } catch (const CLI::ParseError& problem) {
    return fail({ErrorCode::kUsage, in_words(app_, problem)});
  }
  if (const auto ok = refuse_empty(app_); !ok) return fail(ok.error());
  const auto json =
      refuse_unwritable({{"--json", settings_.json}, {"--json", demo_settings_.json}},
                        {settings_.config.output.folder, demo_settings_.config.output.folder});
  if (!json) return fail(json.error());
  Console console(verbose_);
  const std::vector<std::string> arguments(argv, argv + argc);
  for (const CLI::App* verb : app_.get_subcommands()) {
    for (const auto& line : renamed_options(options_of(verb->get_name()), arguments)) {
      console.report(Severity::kWarning, "command line", line);
    }
  }
  const auto outcome = verb_(console);
  if (outcome) {
    std::cout << std::flush;
    if (!std::cout) return fail({ErrorCode::kIo, "standard output: could not be written"});
    return kExitOk;
  }
  console.end("stopped");
  return fail(outcome.error());
}

int run_command_line(int argc, const char* const* argv) {
  return run_guarded("sonde", [&] { return CommandLine().run(argc, argv); });
}

}  // namespace nav::app
