// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "app/verbs/demo.hpp"
#include "app/verbs/derive.hpp"
#include "app/verbs/replay.hpp"
#include "app/verbs/simulate/simulate.hpp"
#include "app/verbs/slices.hpp"

namespace nav::app {

/// The session file first, then what the command line says on top: parsing twice keeps one list of
/// options.
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
    add_demo();
    add_replay();
    add_register();
    add_info();
    add_slices();
    add_predicates();
    add_derive();
    add_bench_program();
    add_devices();
    add_simulate();
  }

  /// The exit code.
  int run(int argc, const char* const* argv);

 private:
  void add_demo();
  void add_replay();
  void add_register();
  void add_info();
  void add_slices();
  void add_predicates();
  void add_derive();
  void add_bench_program();
  void add_devices();
  void add_simulate();
  void add_json(CLI::App& verb) {
    verb.add_option("--json", json_, "write the report as JSON here too; -: standard output");
  }
  [[nodiscard]] std::optional<std::string> json() const {
    return json_.empty() ? std::nullopt : std::optional(json_);
  }
  int fail(const Error& error) const;

  CLI::App app_;
  bool verbose_ = false;
  std::string json_;
  std::string session_;
  std::string matrix_;
  std::string path_;
  SessionConfig config_;
  SessionConfig demo_config_;
  DemoOptions demo_;
  RegisterOptions register_;
  SlicesOptions slices_;
  DeriveOptions derive_;
  std::vector<double> target_;
  SimulateOptions simulate_;
  bool accept_unknown_orientation_ = false;
  bool print_session_ = false;
  std::function<Result<void>(Console&)> verb_;
};

/// Prints the session that the options and the file came to.
Result<void> print_session(const SessionConfig& config);

}  // namespace nav::app
