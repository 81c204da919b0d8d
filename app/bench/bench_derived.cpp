// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/bench/bench_derived.hpp"

#include <iostream>

#include "app/report.hpp"

namespace nav::app {

io::Json json_of(const bench::DerivedBenchReport& report) {
  io::Json timings = io::Json::array();
  for (const auto& t : report.timings) {
    timings.push_back({{"feature", t.feature},
                       {"cpu_s", t.taken.cpu_s},
                       {"wall_s", t.taken.wall_s},
                       {"goal_wall_s", json_number(t.goal_s)},
                       {"bytes_per_voxel", t.bytes_per_voxel},
                       {"note", t.note},
                       {"itk", t.peer},
                       {"itk_cpu_s", json_number(t.peer_taken.cpu_s)},
                       {"itk_wall_s", json_number(t.peer_taken.wall_s)},
                       {"itk_over_sonde", json_number(t.ratio())}});
  }
  io::Json errors = io::Json::array();
  for (const auto& e : report.errors) {
    errors.push_back({{"feature", e.feature},
                      {"setting", e.setting},
                      {"cpu_s", e.cpu_s},
                      {"rms", e.rms},
                      {"max", e.max},
                      {"median_value", json_number(e.median_value)}});
  }
  return {{"side", report.side}, {"timings", std::move(timings)}, {"errors", std::move(errors)}};
}

Result<void> run_bench_derived(const BenchDerivedOptions& options, Console& console) {
  bench::DerivedBenchOptions measured;
  measured.side = options.quick ? 96 : options.side;
  measured.threads = options.threads;
  if (options.quick) measured.repeats = {1, 0};
  console.begin("derived volumes");
  const auto report =
      bench::measure_derived(measured, [&](double share) { console.progress(share); });
  if (!report) return report.error();
  console.end();
  std::cout << bench::to_text(*report) << std::flush;
  if (!options.json) return {};
  io::Json json;
  json["verb"] = "bench derived";
  json["version"] = SONDE_VERSION;
  json["quick"] = options.quick;
  json.update(json_of(*report));
  return write_json(json, *options.json);
}

}  // namespace nav::app
