// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "bench/live/clock_runs.hpp"
#include "bench/live/fault_runs.hpp"
#include "io/json.hpp"

namespace nav::bench {

struct BenchDevicesOptions {
  bool quick = false;              ///< Few and short recordings: seconds.
  int recordings = 1008;           ///< Recordings with faults.
  std::vector<std::string> parts;  ///< faults, clock; empty: all.
  std::optional<std::string> json;
};

/// Images shown of recordings with faults, and the error of the clock model. JSON keys are in
/// docs/json.md.
Result<void> run_bench_devices(const BenchDevicesOptions& options, app::Console& console);

io::Json json_of(const std::vector<FaultRuns>& rows);
io::Json json_of(const std::vector<ClockRuns>& rows);

}  // namespace nav::bench
