// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_devices.hpp"

#include <iostream>

#include "app/report.hpp"
#include "bench/verbs/bench.hpp"

namespace nav::bench {

io::Json json_of(const std::vector<FaultRuns>& rows) {
  io::Json json = io::Json::array();
  for (const FaultRuns& r : rows) {
    json.push_back({{"fault", r.fault},
                    {"recordings", r.recordings},
                    {"images", r.images},
                    {"valid", r.valid},
                    {"wrong", r.wrong},
                    {"worst_mm", r.worst_mm},
                    {"good", r.good},
                    {"withheld", r.withheld}});
  }
  return json;
}

io::Json json_of(const std::vector<ClockRuns>& rows) {
  io::Json json = io::Json::array();
  for (const ClockRuns& r : rows) {
    json.push_back({{"rate_hz", r.rate_hz},
                    {"stamp_ms", r.stamp_ms},
                    {"error_p95_ms", app::json_number(r.error_p95_ms)},
                    {"error_max_ms", app::json_number(r.error_max_ms)},
                    {"skew_ppm", r.skew_ppm},
                    {"rejected", r.rejected},
                    {"false_steps", r.false_steps},
                    {"steps_found", r.steps_found},
                    {"ns_per_sample", r.ns_per_sample}});
  }
  return json;
}

io::Json json_of(const std::vector<CodecRun>& rows) {
  io::Json json = io::Json::array();
  for (const CodecRun& r : rows) {
    json.push_back({{"codec", r.codec},
                    {"bytes", r.bytes},
                    {"messages_per_s", r.per_second},
                    {"mb_per_s", r.mb_per_second},
                    {"goal", r.goal.empty() ? io::Json() : io::Json(r.goal)}});
  }
  return json;
}

io::Json json_of(const RecorderRun& run) {
  return {{"memory_backed", run.memory_backed},
          {"mb_per_s", run.mb_per_second},
          {"seconds", run.seconds},
          {"core_share", run.core_share},
          {"samples", run.samples},
          {"lost", run.lost},
          {"ledger_balanced", run.balanced}};
}

Result<void> run_bench_devices(const BenchDevicesOptions& options, app::Console& console) {
  io::Json json;
  json["verb"] = "bench devices";
  json["version"] = SONDE_VERSION;
  json["quick"] = options.quick;
  const auto progress = [&](double share) { console.progress(share); };
  if (asks_for(options.parts, "faults")) {
    console.begin("faults");
    const FaultRunsOptions runs{.recordings = options.quick ? 36 : options.recordings,
                                .seconds = options.quick ? 8.0 : 20.0};
    const auto rows = measure_fault_runs(runs, progress);
    if (!rows) return rows.error();
    console.end();
    std::cout << to_text(*rows) << std::flush;
    json["faults"] = json_of(*rows);
    json["faults_all"] = json_of({sum_of(*rows)})[0];
  }
  if (asks_for(options.parts, "clock")) {
    console.begin("clock");
    const ClockRunsOptions runs{.seconds = options.quick ? 60.0 : 3600.0,
                                .steps = options.quick ? 10 : 200};
    const auto rows = measure_clock_runs(runs, progress);
    if (!rows) return rows.error();
    console.end();
    std::cout << to_text(*rows) << std::flush;
    json["clock"] = json_of(*rows);
  }
  if (asks_for(options.parts, "codecs")) {
    const auto rows = measure_codecs(options.quick ? 0.1 : 1.0);
    if (!rows) return rows.error();
    std::cout << to_text(*rows) << std::flush;
    json["codecs"] = json_of(*rows);
  }
  if (asks_for(options.parts, "recorder")) {
    const auto run = measure_recorder(options.quick ? 2.0 : 60.0);
    if (!run) return run.error();
    std::cout << to_text(*run) << std::flush;
    json["recorder"] = json_of(*run);
  }
  return options.json ? app::write_json(json, *options.json) : Result<void>();
}

}  // namespace nav::bench
