// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/bench_registration.hpp"

#include <filesystem>
#include <iostream>
#include <unistd.h>

#include "app/report.hpp"
#include "bench/registration/effort_curve.hpp"
#include "bench/registration/peer.hpp"
#include "bench/registration/summary.hpp"

namespace nav::app {
namespace {

// Everything was tuned on the former and nothing on the latter; neither overlaps the seeds of the
// demo, the tests or the acceptance limits.
constexpr std::uint64_t kDevelopmentSeed = 501;
constexpr std::uint64_t kEvaluationSeed = 901;

Json json_of(const bench::CohortSummary& s) {
  Json distances = Json::array();
  for (const auto& row : s.distances) {
    distances.push_back({{"global", row.global},
                         {"start_mm", row.start_mm},
                         {"trials", row.trials},
                         {"right", row.right},
                         {"accepted", row.accepted},
                         {"error_median_mm", json_number(row.error_median_mm)}});
  }
  Json hopeless = Json::array();
  for (const auto& row : s.hopeless) {
    hopeless.push_back({{"kind", bench::to_string(row.kind)},
                        {"trials", row.trials},
                        {"refused", row.refused},
                        {"false_accepts", row.false_accepts}});
  }
  return {{"trials", s.trials},
          {"tre_median_mm", json_number(s.tre_median_mm)},
          {"tre_p95_mm", json_number(s.tre_p95_mm)},
          {"success_from_40mm", json_number(s.success_from_40mm)},
          {"success_local_10mm", json_number(s.success_local_10mm)},
          {"false_accepts", s.false_accepts},
          {"false_accept_bound", s.false_accept_bound},
          {"false_refusals", s.false_refusals},
          {"right", s.right},
          {"hopeless_refused", json_number(s.hopeless_refused)},
          {"coverage_95", json_number(s.coverage_95)},
          {"local_cpu_s", json_number(s.local_cpu_s)},
          {"global_cpu_s", json_number(s.global_cpu_s)},
          {"local_solve_cpu_s", json_number(s.local_solve_cpu_s)},
          {"global_solve_cpu_s", json_number(s.global_solve_cpu_s)},
          {"ct_cpu_s", json_number(s.ct_cpu_s)},
          {"distances", distances},
          {"hopeless", hopeless}};
}

Json json_of(const bench::PeerComparison& comparison) {
  Json rows = Json::array();
  for (const auto& row : comparison.rows) {
    rows.push_back({{"name", row.name},
                    {"start_mm", row.start_mm},
                    {"trials", row.trials},
                    {"right", row.right},
                    {"error_median_mm", json_number(row.error_median_mm)},
                    {"cpu_s", json_number(row.cpu_s)},
                    {"solve_cpu_s", json_number(row.solve_cpu_s)}});
  }
  return rows;
}

Json json_of(const std::vector<bench::EffortPoint>& points) {
  Json rows = Json::array();
  for (const auto& p : points) {
    rows.push_back({{"axis", p.axis},
                    {"x", p.x},
                    {"trials", p.trials},
                    {"right", p.right},
                    {"error_median_mm", json_number(p.error_median_mm)},
                    {"error_p95_mm", json_number(p.error_p95_mm)},
                    {"solve_cpu_s", json_number(p.solve_cpu_s)},
                    {"cpu_s", json_number(p.cpu_s)}});
  }
  return rows;
}

/// Settings of a cohort; the quick one takes two paths and every other distance.
bench::CohortOptions cohort(std::uint64_t first_seed, bool quick) {
  bench::CohortOptions options = bench::default_cohort();
  options.first_seed = first_seed;
  if (!quick) return options;
  options.patients = 2;
  options.paths = {bench::SweepPath::kSubcostal, bench::SweepPath::kSagittal};
  options.local_mm = {10};
  options.global_mm = {20, 40};
  options.starts = 1;
  options.hopeless_stride = 3;
  return options;
}

Result<bench::PeerComparison> beside_elastix(bool quick, Console& console) {
  const bench::CohortOptions ours = bench::default_cohort();
  bench::PeerOptions options;
  options.first_seed = kDevelopmentSeed;
  options.local = ours.local;
  options.global = ours.global;
  if (quick) {
    options.patients = 1;
    options.starts_mm = {5};
    options.efforts = {{150, 2000}};
  }
  std::string folder = (std::filesystem::temp_directory_path() / "sonde-elastix-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) {
    return Error{ErrorCode::kIo, folder + ": expected to make a folder for elastix"};
  }
  auto compared = bench::compare_with_elastix(options, bench::find_elastix(), folder,
                                              [&](double fraction) { console.progress(fraction); });
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return compared;
}

Json or_null(const std::optional<double>& value) {
  return value ? json_number(*value) : Json(nullptr);
}

}  // namespace

Result<void> run_bench_registration(const BenchRegistrationOptions& options, Console& console) {
  const auto show = [&](double fraction) { console.progress(fraction); };
  std::cout << "Simulated patients only: nothing here is clinical accuracy.\n";
  console.begin("development seeds");
  const auto development =
      bench::summarise(bench::run_cohort(cohort(kDevelopmentSeed, options.quick), show));
  console.end();
  std::cout << bench::to_text(development, "development seeds") << std::flush;
  bench::CohortSummary evaluation = development;
  if (options.evaluate) {
    console.begin("evaluation seeds");
    evaluation = bench::summarise(bench::run_cohort(cohort(kEvaluationSeed, options.quick), show));
    console.end();
    std::cout << bench::to_text(evaluation, "evaluation seeds") << std::flush;
  }
  console.begin("run time against error");
  bench::EffortOptions effort;
  effort.first_seed = kDevelopmentSeed;
  effort.local = bench::default_cohort().local;
  if (options.quick) {
    effort.patients = 1;
    effort.patch_shares = {0.25, 4};
    effort.pictures = {};
  }
  const auto curve = bench::measure_effort(effort, show);
  console.end();
  std::cout << bench::to_text(curve) << std::flush;
  console.begin("beside elastix");
  const auto peer = beside_elastix(options.quick, console);
  if (!peer) return peer.error();
  console.end();
  std::cout << bench::to_text(*peer) << std::flush;
  if (!options.json) return {};

  Json json;
  json["verb"] = "bench registration";
  json["version"] = SONDE_VERSION;
  json["quick"] = options.quick;
  json["simulated"] = true;
  json["summary"] = json_of(evaluation);
  json["summary"]["cpu_ratio_elastix"] = or_null(peer->cpu_ratio);
  json["summary"]["solve_cpu_ratio_elastix"] = or_null(peer->solve_cpu_ratio);
  json["summary"]["cpu_ratio_elastix_reason"] =
      peer->cpu_ratio ? Json(nullptr) : Json(peer->reason);
  json["summary_seeds"] = options.evaluate ? "evaluation" : "development";
  json["development"] = json_of(development);
  json["curve"] = json_of(curve);
  json["peer"] = json_of(*peer);
  return write_json(json, *options.json);
}

}  // namespace nav::app
