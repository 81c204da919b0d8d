// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_command_line.hpp"

#include <iostream>

#include "app/options/exit_code.hpp"
#include "app/options/option_checks.hpp"
#include "app/options/overwriting.hpp"
#include "app/options/program.hpp"
#include "app/options/verb_table.hpp"
#include "bench/verbs/bench_verbs.hpp"

namespace nav::bench {
namespace {

constexpr const char* kProgram = "sonde-bench";

/// The examples of a verb of the program sonde.
std::string examples_of(const char* verb) {
  std::string text = "Examples:\n";
  for (const std::string& example : app::find_verb(verb)->examples) text += "  " + example + "\n";
  return text;
}

/// Types of values that the help shows; ranges are checks of the options.
constexpr std::pair<const char*, const char*> kTypes[] = {
    {"--ct", "CT"},     {"--scene", "TEXT"}, {"--part", "LIST"},   {"--width", "N"},
    {"--height", "N"},  {"--largest", "N"},  {"--patients", "N"},  {"--trials", "FILE"},
    {"--side", "N"},    {"--threads", "N"},  {"--engine", "NAME"}, {"--volume", "NAME"},
    {"--look", "NAME"}, {"--model", "NAME"}, {"--effort", "NAME"}, {"--recordings", "N"},
    {"--json", "FILE"}, {"--out", "DIR"},    {"--only", "TEXT"}};

void show_types(CLI::App& program) {
  for (CLI::App* verb : program.get_subcommands([](const CLI::App*) { return true; })) {
    for (const auto& [name, type] : kTypes) {
      if (CLI::Option* option = verb->get_option_no_throw(name)) option->type_name(type);
    }
  }
}

}  // namespace

BenchCommandLine::BenchCommandLine()
    : app_("sonde-bench: measures Sonde's run time against error, and draws its gallery.") {
  app_.set_help_all_flag("--help-all", "print the help of every part");
  app_.footer(examples_of("bench"));
  app_.set_version_flag("--version", "sonde-bench " SONDE_VERSION);
  app_.require_subcommand(1);
  app_.add_flag("-v,--verbose", verbose_, "also show information of the libraries");
  app_.fallthrough();
  add_render();
  add_predicates();
  add_scaling();
  add_registration();
  add_derived();
  add_vessels();
  add_reconstruct();
  add_devices();
  add_gallery();
  show_types(app_);
  app_.get_subcommand("gallery")->footer(examples_of("gallery"));
}

int BenchCommandLine::run(int argc, const char* const* argv) {
  const auto fail = [](const Error& error) { return app::print_error(kProgram, error); };
  try {
    app_.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return app_.exit(success);
  } catch (const CLI::ParseError& problem) {
    return fail({ErrorCode::kUsage, app::in_words(app_, problem)});
  }
  if (const auto ok = app::reject_empty(app_); !ok) return fail(ok.error());
  if (const auto ok = app::reject_unwritable({{"--json", json_}}); !ok) return fail(ok.error());
  app::Console console(verbose_);
  const auto outcome = verb_(console);
  if (!outcome) {
    console.end("stopped");
    return fail(outcome.error());
  }
  std::cout << std::flush;
  if (!std::cout) return fail({ErrorCode::kIo, "standard output: could not be written"});
  return app::kExitOk;
}

int run_command_line(int argc, const char* const* argv) {
  return app::run_guarded(kProgram, [&] { return BenchCommandLine().run(argc, argv); });
}

}  // namespace nav::bench
