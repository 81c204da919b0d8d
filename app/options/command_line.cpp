// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/command_line.hpp"

#include <algorithm>
#include <iostream>
#include <memory>
#include <utility>

#include "app/options/exit_code.hpp"
#include "app/options/option_checks.hpp"
#include "app/options/option_help.hpp"
#include "app/options/option_parser.hpp"
#include "app/options/overwriting.hpp"
#include "app/options/program.hpp"
#include "app/options/verbs.hpp"
#include "app/verbs/devices.hpp"
#include "app/verbs/info.hpp"
#include "app/verbs/other_program.hpp"
#include "io/atomic_file.hpp"

namespace nav::app {
namespace {

std::vector<std::pair<std::string, std::string>> verbs_of(const CLI::App& app) {
  std::vector<std::pair<std::string, std::string>> verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    verbs.emplace_back(verb->get_name(), verb->get_description());
  }
  return verbs;
}

/// Help from the tables; the parser's own for verbs that are not in them.
class TableFormatter final : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    if (app->get_parent() == nullptr) return program_help(verbs_of(*app));
    const Verb* verb = find_verb(app->get_name());
    if (verb != nullptr) return verb_help(*verb, mode == CLI::AppFormatMode::All);
    return CLI::Formatter::make_help(app, std::move(name), mode);
  }
};

}  // namespace

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
      if (auto ok = reject_overwriting({{"--json", settings_.json}}, inputs); !ok) return ok;
      return run_info(settings_.file, json(), settings_.config.ct.accept_unknown_orientation,
                      console);
    };
  });
}

void CommandLine::add_bench_program() {
  for (const char* name : {"bench", "gallery"}) {
    CLI::App* verb = app_.add_subcommand(name, find_verb(name)->summary);
    // run() hands the command line over before it is parsed.
    verb->callback([this, name = std::string(name)] {
      verb_ = [name](Console&) -> Result<void> {
        return Error{ErrorCode::kUsage, name + ": expected it as the first word, found others"};
      };
    });
  }
}

void CommandLine::add_window() {
  add_verb("window", settings_).callback([this] {
    // run() hands the command line over before it is parsed.
    verb_ = [](Console&) -> Result<void> {
      return Error{ErrorCode::kUsage, "window: expected it as the first word, found others"};
    };
  });
}

void CommandLine::prepare_help() {
  app_.set_help_all_flag("--help-all", "print all options");
  app_.formatter(std::make_shared<TableFormatter>());
}

void CommandLine::add_help() {
  // run() answers both before the command line is parsed.
  for (const char* name : {"help", "completion"}) {
    app_.add_subcommand(name, find_verb(name)->summary)->callback([this, name = std::string(name)] {
      verb_ = [name](Console&) -> Result<void> {
        return Error{ErrorCode::kUsage, name + ": expected it as the first word, found others"};
      };
    });
  }
}

Result<std::string> CommandLine::generated(const std::vector<std::string>& words) const {
  std::vector<std::string> names;
  for (const auto& [name, summary] : verbs_of(app_)) names.push_back(name);
  if (words.at(0) == "completion") {
    if (words.size() == 2 && words[1] == "bash") return bash_completion(names);
    return Error{ErrorCode::kUsage, "completion: expected bash, found " +
                                        (words.size() < 2 ? "none" : "'" + words[1] + "'")};
  }
  if (words.size() == 3 && words[1] == "--tables") {
    const auto page = io::read_file(words[2], 1 << 24);
    if (!page) return page.error();
    auto text = with_tables(*page);
    if (!text) return Error{text.error().code, words[2] + ": " + text.error().message};
    return text;
  }
  if (words.size() == 3 && words[1] == "--man") {
    if (const Verb* verb = find_verb(words[2])) return man_page(*verb);
  }
  return Error{ErrorCode::kUsage,
               "help: expected a verb, or --man and a verb, found '" + words.back() + "'"};
}

int CommandLine::fail(const Error& error) const { return print_error("sonde", error); }

std::optional<int> CommandLine::parse(int argc, const char* const* argv) {
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
  if (const auto ok = reject_empty(app_); !ok) return fail(ok.error());
  const auto json =
      reject_unwritable({{"--json", settings_.json}, {"--json", demo_settings_.json}},
                        {settings_.config.output.folder, demo_settings_.config.output.folder});
  if (!json) return fail(json.error());
  return std::nullopt;
}

int CommandLine::run(int argc, const char* const* argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  const std::string first = words.empty() ? "" : words.front();
  const bool all = words.size() == 3 && words[2] == "--help-all";
  const bool known =
      (words.size() == 2 || all) &&
      std::ranges::any_of(verbs_of(app_), [&](const auto& verb) { return verb.first == words[1]; });
  if (first == "help" && (known || words.size() == 1)) {
    // "help VERB" is "VERB --help", "help VERB --help-all" all of it, "help" alone "--help".
    const char* const asked[] = {argv[0], known ? argv[2] : "--help",
                                 all ? "--help-all" : "--help"};
    return run(known ? 3 : 2, asked);
  }
  const bool asks_help = !words.empty() && words.back().starts_with("--help");
  if ((first == "help" || first == "completion") && !asks_help) {
    const auto text = generated(words);
    if (!text) return fail(text.error());
    std::cout << *text << std::flush;
    return std::cout ? kExitOk : fail({ErrorCode::kIo, "standard output: could not be written"});
  }
  const bool help_of_window = first == "window" && asks_help;
  if (const auto other = other_program(argc, argv); other && !help_of_window) {
    return fail(run_other_program(*other));
  }
  if (const auto code = parse(argc, argv)) return *code;
  Console console(verbose_);
  const std::vector<std::string> arguments(argv, argv + argc);
  for (const CLI::App* verb : app_.get_subcommands()) {
    for (const auto& line : renamed_options(options_of(verb->get_name()), arguments)) {
      console.report(Severity::kWarning, "command line", line);
    }
  }
  const auto outcome = verb_(console);
  if (outcome) {
    console.say_suppressed();
    std::cout << std::flush;
    if (!std::cout) return fail({ErrorCode::kIo, "standard output: could not be written"});
    return kExitOk;
  }
  console.end("stopped");
  console.say_suppressed();
  return fail(outcome.error());
}

int run_command_line(int argc, const char* const* argv) {
  return run_guarded("sonde", [&] { return CommandLine().run(argc, argv); });
}

}  // namespace nav::app
