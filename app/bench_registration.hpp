// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "app/console.hpp"
#include "nav/result.hpp"

namespace nav::app {

struct BenchRegistrationOptions {
  bool quick = false;    ///< A stratified part of the cohort: about two minutes on two cores.
  bool evaluate = true;  ///< False: only the development seeds.
  std::optional<std::string> json;
};

/// Registration on the simulated cohort: development and evaluation seeds side by side, run time
/// against error, and elastix where it is installed. Prints tables; JSON keys are in docs/json.md.
Result<void> run_bench_registration(const BenchRegistrationOptions& options, Console& console);

}  // namespace nav::app
