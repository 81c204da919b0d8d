// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "bench/live/clock_runs.hpp"
#include "bench/live/codec_runs.hpp"
#include "bench/live/fault_runs.hpp"
#include "bench/live/recorder_runs.hpp"
#include "io/json.hpp"

namespace nav::bench {

struct BenchDevicesOptions {
  bool quick = false;              ///< Few and short recordings: seconds.
  int recordings = 1008;           ///< Recordings with faults.
  std::vector<std::string> parts;  ///< faults, clock, codecs, recorder; empty: all.
  std::optional<std::string> json;
};

/// Images shown of recordings with faults, the error of the clock model, and the throughput of
/// codecs and recorder. JSON keys are in docs/json.md.
Result<void> run_bench_devices(const BenchDevicesOptions& options, app::Console& console);

io::Json json_of(const std::vector<FaultRuns>& rows);
io::Json json_of(const std::vector<ClockRuns>& rows);
io::Json json_of(const std::vector<CodecRun>& rows);
io::Json json_of(const RecorderRun& run);

}  // namespace nav::bench
