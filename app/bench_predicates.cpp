// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "app/bench.hpp"
#include "app/report.hpp"
#include "bench/predicate_bench.hpp"

namespace nav::app {
namespace {

Json row_json(const bench::PredicateBenchRow& row) {
  return {{"scene", row.scene},
          {"standard_cpu_ms", row.standard_cpu_ms},
          {"predicate_cpu_ms", row.predicate_cpu_ms},
          {"brute_force_cpu_ms", row.brute_cpu_ms},
          {"standard_samples", row.standard_samples},
          {"predicate_samples", row.predicate_samples},
          {"brute_force_samples", row.brute_samples},
          {"max_error_early_termination", row.max_error},
          {"skipping_is_bit_identical", row.identical},
          {"importance_edit_ms", row.prepare_ms},
          {"set_edit_ms", row.set_edit_ms}};
}

Json report_json(const bench::PredicateBenchReport& report) {
  Json rows = Json::array();
  for (const auto& row : report.rows) rows.push_back(row_json(row));
  return {{"scenes", std::move(rows)},
          {"rays_checked", report.rays_checked},
          {"naive_termination_error", report.naive_error},
          {"engine_megabytes", report.megabytes},
          {"ratios",
           {{"predicate_over_standard_fps", report.predicate_over_standard()},
            {"predicate_over_brute_force_fps", report.brute_over_predicate()},
            {"max_error_early_termination", report.max_error()},
            {"bound_violations", report.bound_violations},
            // The shader of the paper needs predicates on OpenGL.
            {"vs_paper_shader", nullptr}}}};
}

}  // namespace

Result<void> run_bench_predicates(const BenchPredicatesOptions& options, Console& console) {
  bench::PredicateBenchOptions bench;
  bench.side = options.quick ? 96 : options.side;
  bench.threads = options.threads;
  if (options.quick) {
    bench.width = 200;
    bench.height = 150;
    bench.repeats = {3, 1};
  }
  console.begin("predicates");
  const auto report =
      bench::measure_predicates(bench, console, [&](double done) { console.progress(done); });
  if (!report) return report.error();
  console.end();
  std::cout << bench::to_text(*report) << std::flush;
  if (!options.json) return {};
  Json json;
  json["verb"] = "bench predicates";
  json["version"] = SONDE_VERSION;
  json["quick"] = options.quick;
  json["side"] = bench.side;
  json["width"] = bench.width;
  json["height"] = bench.height;
  json.update(report_json(*report));
  return write_json(json, *options.json);
}

}  // namespace nav::app
