// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "app/options/settings.hpp"
#include "app/options/verb_table.hpp"

namespace nav::app {

/// The program's verbs and their options. The session file is read before the command line is
/// parsed, so that options win over it.
class CommandLine {
 public:
  CommandLine()
      : app_(
            "Sonde: live ultrasound inside the CT. Research software, not a medical "
            "device.") {
    app_.set_version_flag("--version", "sonde " SONDE_VERSION);
    app_.require_subcommand(1);
    app_.add_flag("-v,--verbose", verbose_, "also show information of the libraries");
    app_.fallthrough();
    prepare_help();
    add_demo();
    add_replay();
    add_live();
    add_window();
    add_record();
    add_export();
    add_serve();
    add_emulate();
    add_reconstruct();
    add_register();
    add_info();
    add_slices();
    add_predicates();
    add_derive();
    add_bench_program();
    add_devices();
    add_simulate();
    add_help();
  }

  /// The exit code.
  int run(int argc, const char* const* argv);
  /// Takes the session file and the options, which choose the verb, without running it. Returns the
  /// exit code when there is nothing to run: help was printed, or an option was rejected.
  std::optional<int> parse(int argc, const char* const* argv);

 private:
  /// A verb with its options of the table, which store into \p settings.
  CLI::App& add_verb(const char* name, Settings& settings);
  /// Help from the tables. Verbs inherit it, so it comes before them.
  void prepare_help();
  void add_help();
  /// Text that "help --man VERB", "help --tables PAGE" or "completion bash" asks for.
  [[nodiscard]] Result<std::string> generated(const std::vector<std::string>& words) const;
  void add_demo();
  void add_replay();
  void add_live();
  void add_window();
  void add_record();
  void add_export();
  void add_serve();
  void add_emulate();
  void add_reconstruct();
  [[nodiscard]] Result<void> check_live(const std::string& verb) const;
  void add_register();
  void add_info();
  void add_slices();
  void add_predicates();
  void add_derive();
  void add_bench_program();
  void add_devices();
  void add_simulate();
  static std::optional<std::string> json_of(const Settings& settings) {
    return settings.json.empty() ? std::nullopt : std::optional(settings.json);
  }
  [[nodiscard]] std::optional<std::string> json() const { return json_of(settings_); }
  int fail(const Error& error) const;

  CLI::App app_;
  bool verbose_ = false;
  Settings settings_;
  Settings demo_settings_ = default_settings("demo");
  std::function<Result<void>(Console&)> verb_;
};

/// Prints the session that the options and the file came to.
Result<void> print_session(const SessionConfig& config);

}  // namespace nav::app
