// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_reconstruct.hpp"

#include <iostream>

#include "app/report.hpp"
#include "bench/verbs/bench.hpp"

namespace nav::bench {

io::Json json_of(const ReconstructionBenchReport& report) {
  io::Json rates = io::Json::array();
  for (const auto& r : report.rates) {
    rates.push_back({{"method", r.method},
                     {"compound", r.compound},
                     {"images", r.images},
                     {"fps_p50", r.fps_p50},
                     {"fps_p95", r.fps_p95},
                     {"cpu_ms", r.cpu_ms}});
  }
  io::Json errors = io::Json::array();
  for (const auto& e : report.errors) {
    errors.push_back({{"method", e.method},
                      {"compound", e.compound},
                      {"spacing_mm", e.spacing_mm},
                      {"covered", e.covered},
                      {"rms", app::json_number(e.rms)},
                      {"mean", app::json_number(e.mean)},
                      {"rms_everywhere", app::json_number(e.rms_everywhere)},
                      {"seconds", e.seconds}});
  }
  io::Json backward;
  if (const auto& b = report.backward) {
    backward = {{"images", b->images},         {"width", b->width},      {"height", b->height},
                {"spacing_mm", b->spacing_mm}, {"voxels", b->voxels},    {"seen", b->seen},
                {"wall_s", b->taken.wall_s},   {"cpu_s", b->taken.cpu_s}};
  }
  return {{"width", report.width},
          {"height", report.height},
          {"side", report.side},
          {"rates", std::move(rates)},
          {"backward", std::move(backward)},
          {"image_distance_mm", report.image_distance_mm},
          {"neighbour_rms", report.neighbour_rms},
          {"errors", std::move(errors)}};
}

Result<void> run_bench_reconstruct(const BenchReconstructOptions& options, app::Console& console) {
  console.begin("reconstruction");
  const ReconstructionBenchOptions measured{.quick = options.quick,
                                            .threads = options.threads,
                                            .rates = asks_for(options.parts, "rates"),
                                            .backward = asks_for(options.parts, "backward"),
                                            .errors = asks_for(options.parts, "errors")};
  const auto report =
      measure_reconstruction(measured, [&](double share) { console.progress(share); });
  if (!report) return report.error();
  console.end();
  std::cout << to_text(*report) << std::flush;
  if (!options.json) return {};
  io::Json json;
  json["verb"] = "bench reconstruct";
  json["version"] = SONDE_VERSION;
  json["quick"] = options.quick;
  json.update(json_of(*report));
  return app::write_json(json, *options.json);
}

}  // namespace nav::bench
