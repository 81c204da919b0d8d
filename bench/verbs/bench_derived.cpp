// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_derived.hpp"

#include <iostream>

#include "app/report.hpp"

namespace nav::bench {

io::Json json_of(const DerivedBenchReport& report) {
  io::Json timings = io::Json::array();
  for (const auto& t : report.timings) {
    timings.push_back({{"feature", t.feature},
                       {"cpu_s", t.taken.cpu_s},
                       {"wall_s", t.taken.wall_s},
                       {"goal_wall_s", app::json_number(t.goal_s)},
                       {"bytes_per_voxel", t.bytes_per_voxel},
                       {"note", t.note},
                       {"itk", t.peer},
                       {"itk_cpu_s", app::json_number(t.peer_taken.cpu_s)},
                       {"itk_wall_s", app::json_number(t.peer_taken.wall_s)},
                       {"itk_over_sonde", app::json_number(t.ratio())}});
  }
  io::Json errors = io::Json::array();
  for (const auto& e : report.errors) {
    errors.push_back({{"feature", e.feature},
                      {"setting", e.setting},
                      {"cpu_s", e.cpu_s},
                      {"rms", e.rms},
                      {"max", e.max},
                      {"median_value", app::json_number(e.median_value)}});
  }
  return {{"side", report.side}, {"timings", std::move(timings)}, {"errors", std::move(errors)}};
}

Result<void> run_bench_derived(const BenchDerivedOptions& options, app::Console& console) {
  DerivedBenchOptions measured;
  measured.side = options.quick ? 96 : options.side;
  measured.threads = options.threads;
  if (options.quick) measured.repeats = {1, 0};
  console.begin("derived volumes");
  const auto report = measure_derived(measured, [&](double share) { console.progress(share); });
  if (!report) return report.error();
  console.end();
  std::cout << to_text(*report) << std::flush;
  if (!options.json) return {};
  io::Json json;
  json["verb"] = "bench derived";
  json["version"] = SONDE_VERSION;
  json["quick"] = options.quick;
  json.update(json_of(*report));
  return app::write_json(json, *options.json);
}

}  // namespace nav::bench
