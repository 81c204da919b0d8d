// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "bench/gallery/gallery.hpp"
#include "bench/verbs/bench.hpp"
#include "bench/verbs/bench_derived.hpp"
#include "bench/verbs/bench_devices.hpp"
#include "bench/verbs/bench_reconstruct.hpp"
#include "bench/verbs/bench_registration.hpp"
#include "bench/verbs/bench_vessels.hpp"

namespace nav::bench {

/// The command line of sonde-bench.
class BenchCommandLine {
 public:
  BenchCommandLine();

  /// Parses the command line, runs the verb and returns the exit code.
  int run(int argc, const char* const* argv);

 private:
  void add_render();
  void add_predicates();
  void add_scaling();
  void add_registration();
  void add_derived();
  void add_vessels();
  void add_reconstruct();
  void add_devices();
  void add_gallery();
  void add_json(CLI::App& verb) {
    verb.add_option("--json", json_, "also write the report as JSON here; -: standard output");
  }
  [[nodiscard]] std::optional<std::string> json() const {
    return json_.empty() ? std::nullopt : std::optional(json_);
  }

  CLI::App app_;
  bool verbose_ = false;
  std::string json_;
  BenchRenderOptions render_;
  BenchPredicatesOptions predicates_;
  BenchScalingOptions scaling_;
  BenchRegistrationOptions registration_;
  BenchDerivedOptions derived_;
  BenchVesselsOptions vessels_;
  BenchReconstructOptions reconstruct_;
  BenchDevicesOptions devices_;
  GalleryOptions gallery_;
  std::function<Result<void>(app::Console&)> verb_;
};

}  // namespace nav::bench
