// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "nav/result.hpp"
#include "registration/image_registration.hpp"
#include "sim/probe_model.hpp"

namespace nav::bench {

struct BenchRegistrationOptions {
  bool quick = false;    ///< A stratified part of the cohort: about two minutes on two cores.
  bool evaluate = true;  ///< False: only the development seeds.
  int patients = 0;      ///< Patients of each cohort; 0: as many as the cohort has.
  registration::Effort effort = registration::Effort::kUsual;  ///< Used by cohort, faults, starts.
  /// How echoes of the sweeps are computed.
  sim::AcousticModel model = sim::AcousticModel::kRays;
  std::vector<std::string> parts;  ///< Parts to run, values of --part; none: all.
  std::optional<std::string> json;
  std::optional<std::string> trials;  ///< CSV with a line for each registration of the cohorts.
};

/// Registration on the simulated cohort: development and evaluation seeds side by side, run time
/// against error, and elastix where it is installed. Prints tables; JSON keys are in
/// docs/json.md.
Result<void> run_bench_registration(const BenchRegistrationOptions& options, app::Console& console);

}  // namespace nav::bench
