// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <optional>
#include <string_view>

#include "app/report.hpp"
#include "bench/predicate_bench.hpp"
#include "bench/two_volumes.hpp"
#include "bench/verbs/bench.hpp"
#include "bench/verbs/bench_derived.hpp"

namespace nav::bench {
namespace {

/// A --volume that is none: what predicates read, derived.
constexpr std::string_view kFeatures = "features";

io::Json row_json(const PredicateBenchRow& row) {
  return {{"scene", row.scene},
          {"standard_cpu_ms", row.standard_cpu_ms},
          {"predicate_cpu_ms", row.predicate_cpu_ms},
          {"brute_force_cpu_ms", row.brute_cpu_ms},
          {"standard_wall_ms", row.standard_wall_ms},
          {"predicate_wall_ms", row.predicate_wall_ms},
          {"predicate_fps", 1e3 / row.predicate_wall_ms},
          {"standard_samples", row.standard_samples},
          {"predicate_samples", row.predicate_samples},
          {"brute_force_samples", row.brute_samples},
          {"max_error_early_termination", row.max_error},
          {"skipping_is_bit_identical", row.identical},
          {"importance_edit_ms", row.prepare_ms},
          {"set_edit_ms", row.set_edit_ms},
          {"set_edit_wall_ms", row.edit.first_ms},
          {"set_edit_whole_ms", row.edit.whole_ms},
          {"bar_edit_wall_ms", row.bar.first_ms},
          {"bar_edit_whole_ms", row.bar.whole_ms}};
}

io::Json gl_json(const GlPredicateReport& report) {
  io::Json rows = io::Json::array();
  for (const auto& row : report.rows) {
    rows.push_back(
        {{"scene", row.scene},
         {"standard_ms", row.standard_ms},
         {"predicate_ms", row.predicate_ms},
         {"brute_force_ms", row.brute_ms},
         {"paper_shader_ms", row.paper_ms},
         {"max_difference_to_paper_shader", row.paper_difference},
         {"rms_difference_to_paper_shader", row.paper_rms},
         {"paper_shader_own_filter_ms", app::json_number(row.paper_own_filter_ms)},
         {"max_difference_to_paper_shader_own_filter",
          app::json_number(row.paper_own_filter_difference)},
         {"cpu_engine_ms", app::json_number(row.cpu_engine_ms)},
         {"cpu_max_difference_to_paper_shader", app::json_number(row.cpu_paper_difference)},
         {"max_error_early_termination", row.max_error},
         {"skipping_is_bit_identical", row.identical},
         {"importance_edit_ms", row.edit_ms},
         {"set_edit_ms", row.set_edit_ms},
         {"set_edit_wall_ms", row.edit.first_ms},
         {"set_edit_provisional", row.edit.provisional},
         {"set_edit_whole_ms", row.edit.whole_ms},
         {"settle_ms", row.settle_ms}});
  }
  return {{"device", report.device},
          {"width", report.width},
          {"height", report.height},
          {"scenes", std::move(rows)}};
}

io::Json report_json(const PredicateBenchReport& report) {
  io::Json rows = io::Json::array();
  for (const auto& row : report.rows) rows.push_back(row_json(row));
  const auto of_gl = [&](double (GlPredicateReport::*value)() const) {
    return report.gl ? io::Json((*report.gl.*value)()) : io::Json();
  };
  const auto maybe_of_gl = [&](std::optional<double> (GlPredicateReport::*value)() const) {
    return report.gl ? app::json_number((*report.gl.*value)()) : io::Json();
  };
  using Gl = GlPredicateReport;
  return {{"scenes", std::move(rows)},
          {"gl", report.gl ? gl_json(*report.gl) : io::Json()},
          {"rays_checked", report.rays_checked},
          {"naive_termination_error", report.naive_error},
          {"engine_megabytes", app::json_number(report.megabytes)},
          {"ratios",
           {{"predicate_over_standard_fps", report.predicate_over_standard()},
            {"predicate_over_brute_force_fps", report.brute_over_predicate()},
            {"max_error_early_termination", report.max_error()},
            {"bound_violations", report.bound_violations},
            {"worst_set_edit_wall_ms", report.worst_set_edit_wall_ms()},
            {"worst_whole_ms", report.worst_whole_ms()},
            {"gl_predicate_over_standard_fps", of_gl(&Gl::predicate_over_standard)},
            {"gl_max_error_early_termination", of_gl(&Gl::max_error)},
            {"gl_worst_set_edit_ms", of_gl(&Gl::worst_set_edit_ms)},
            {"gl_worst_set_edit_wall_ms", of_gl(&Gl::worst_set_edit_wall_ms)},
            {"vs_paper_shader", maybe_of_gl(&Gl::vs_paper_shader)},
            {"vs_paper_shader_own_filter", maybe_of_gl(&Gl::vs_paper_shader_own_filter)},
            {"cpu_vs_paper_shader", maybe_of_gl(&Gl::cpu_vs_paper_shader)}}}};
}

io::Json report_json(const TwoVolumesReport& report) {
  io::Json rows = io::Json::array();
  const std::string unit = report.engine == "cpu" ? "_cpu_ms" : "_ms";
  for (const auto& row : report.rows) {
    rows.push_back({{"step_voxels", row.step_voxels},
                    {"rms", row.rms},
                    {"ct" + unit, row.ct_ms},
                    {"ultrasound" + unit, row.ultrasound_ms},
                    {"both" + unit, row.both_ms},
                    {"ct_samples", row.ct_samples},
                    {"ultrasound_samples", row.ultrasound_samples},
                    {"both_samples", row.both_samples}});
  }
  return {{"device", report.device},
          {"width", report.width},
          {"height", report.height},
          {"reference_rms", report.reference_rms},
          {"importance_edit_ms", report.edit_ms},
          {"steps", std::move(rows)}};
}

/// JSON of `two_volumes`, by the names of the engines.
Result<io::Json> measure_two(const PredicateBenchOptions& options, app::Console& console) {
  std::vector<EngineMaker> engines;
  if (options.cpu) engines.emplace_back([] { return render::make_cpu_engine({.threads = 1}); });
  if (options.gl) {
    const auto gl = render::make_gl_engine(console);
    if (gl) {
      engines.emplace_back([&console] { return render::make_gl_engine(console); });
    } else {
      console.report(Severity::kWarning, "bench", "skipped: " + gl.error().message);
    }
  }
  console.begin("a CT with ultrasound in it");
  auto measured = measure_two_volumes(std::min(options.side, 512), options.width, options.height,
                                      options.repeats, engines);
  if (!measured) return measured.error();
  console.end();
  io::Json json;
  for (const TwoVolumesReport& report : *measured) {
    std::cout << to_text(report) << std::flush;
    if (report.engine == "cpu") {
      json.update(report_json(report));
    } else {
      json["gl"] = report_json(report);
    }
  }
  return json;
}

/// Measures features that predicates read and that take long to derive, beside ITK.
Result<io::Json> measure_features(bool quick, int threads, app::Console& console) {
  DerivedBenchOptions derived;
  derived.features = {"snr", "vesselness", "confidence"};
  derived.threads = threads;
  if (quick) {
    derived.side = 96;
    derived.repeats = {1, 0};
  }
  console.begin("features that predicates read");
  const auto report = measure_derived(derived, [&](double share) { console.progress(share); });
  if (!report) return report.error();
  console.end();
  std::cout << to_text(*report) << std::flush;
  return json_of(*report);
}

}  // namespace

Result<void> run_bench_predicates(const BenchPredicatesOptions& options, app::Console& console) {
  PredicateBenchOptions bench;
  bench.side = options.quick ? 96 : options.side;
  bench.width = options.width;
  bench.height = options.height;
  bench.threads = options.threads;
  bench.volume = options.volume;
  bench.appearance = options.appearance;
  bench.cpu = options.engine != "gl";
  bench.gl = options.engine != "cpu";
  if (options.quick) {
    bench.width = 200;
    bench.height = 150;
    bench.repeats = {3, 1};
  }
  std::optional<PredicateBenchReport> report;
  const bool only_features = !bench.volume.empty() && kFeatures.starts_with(bench.volume);
  if (!bench.volume.starts_with("two") && !only_features) {
    console.begin("predicates");
    auto measured =
        measure_predicates(bench, console, [&](double done) { console.progress(done); });
    if (!measured) return measured.error();
    report = *std::move(measured);
    console.end();
    std::cout << to_text(*report) << std::flush;
  }
  io::Json two;
  if (std::string_view("two-volumes").starts_with(bench.volume)) {
    auto measured = measure_two(bench, console);
    if (!measured) return measured.error();
    two = *std::move(measured);
  }
  io::Json features;
  if (bench.cpu && (bench.volume.empty() || only_features)) {
    auto measured = measure_features(options.quick, options.threads, console);
    if (!measured) return measured.error();
    features = *std::move(measured);
  }
  if (!options.json) return {};
  io::Json json;
  json["verb"] = "bench predicates";
  json["version"] = SONDE_VERSION;
  json["quick"] = options.quick;
  json["side"] = bench.side;
  json["width"] = bench.width;
  json["height"] = bench.height;
  if (report) json.update(report_json(*report));
  json["two_volumes"] = std::move(two);
  json["features"] = std::move(features);
  return app::write_json(json, *options.json);
}

}  // namespace nav::bench
