// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_json.hpp"

#include <cmath>
#include <functional>
#include <iomanip>
#include <sstream>

namespace nav::bench {
namespace {

/// Worst over the errors of each scene, and the median of those.
io::Json summary(const RenderBenchReport& report, const std::string& name,
                 std::optional<bool> shaded) {
  io::Json scenes = io::Json::object();
  std::vector<double> all;
  for (const auto& ratio : report.ratios) {
    if (ratio.name != name || (shaded && ratio.shaded != *shaded)) continue;
    const double least = worst(ratio.levels);
    scenes[ratio.scene] = app::json_number(least);
    if (std::isfinite(least)) all.push_back(least);
  }
  const double least = all.empty() ? std::nan("") : *std::min_element(all.begin(), all.end());
  return {{"median", app::json_number(median(all))},
          {"worst", app::json_number(least)},
          {"scenes", std::move(scenes)}};
}

/// Sonde's time to 5e-3 rms over VTK's cheapest image, besides the summary.
io::Json fixed_point_summary(const RenderBenchReport& report) {
  io::Json out = summary(report, "cpu_vs_vtk_fixedpoint", {});
  io::Json scenes = io::Json::object();
  for (const auto& ratio : report.ratios) {
    if (ratio.name != "cpu_vs_vtk_fixedpoint") continue;
    scenes[ratio.scene] = app::json_number(ratio.fine_over_their_cheapest);
  }
  out["time_to_5e-3_over_their_cheapest"] = std::move(scenes);
  return out;
}

using SkipMeasure = double (SkipRatio::*)() const;

/// Over the scenes whose name contains this; NaN when none was drawn.
double median_skip(const BenchRenderReport& report, SkipMeasure measure,
                   const std::string& containing = "") {
  std::vector<double> ratios;
  for (const auto& one : report.skipping) {
    if (one.scene.find(containing) != std::string::npos) ratios.push_back((one.*measure)());
  }
  return median(std::move(ratios));
}

io::Json skip_summary(const BenchRenderReport& report) {
  constexpr SkipMeasure kSkipping = &SkipRatio::ratio;
  constexpr SkipMeasure kAll = &SkipRatio::brute_ratio;
  io::Json scenes = io::Json::object();
  bool identical = true;
  for (const auto& one : report.skipping) {
    scenes[one.scene] = {{"skipping", one.ratio()}, {"and_early_end", one.brute_ratio()}};
    identical = identical && one.identical;
  }
  return {
      {"median", app::json_number(median_skip(report, kSkipping))},
      {"vessels_only", app::json_number(median_skip(report, kSkipping, "vessels-only"))},
      {"and_early_end_median", app::json_number(median_skip(report, kAll))},
      {"and_early_end_vessels_only", app::json_number(median_skip(report, kAll, "vessels-only"))},
      {"full_volume_overhead", app::json_number(report.full_volume_overhead)},
      {"bit_identical", report.skipping.empty() ? io::Json() : io::Json(identical)},
      {"scenes", std::move(scenes)}};
}

io::Json as_json(const CutawayCost& cutaway) {
  return {{"fraction", app::json_number(cutaway.own_fraction())},
          {"fraction_at_most", app::json_number(cutaway.own_fraction_at_most())},
          {"net_fraction", app::json_number(cutaway.net_fraction())},
          {"ct_ms", cutaway.ct_ms},
          {"coarse_ct_ms", cutaway.coarse_ct_ms},
          {"plane_ms", cutaway.plane_ms},
          {"cutaway_ms", cutaway.cutaway_ms},
          {"samples_ct", cutaway.ct_samples},
          {"samples_coarse_ct", cutaway.coarse_ct_samples},
          {"samples_without_cutaway", cutaway.plane_samples},
          {"samples_with_cutaway", cutaway.cutaway_samples}};
}

io::Json as_json(const ImageUpdate& update) {
  return {{"cpu_ms", update.cpu_ms},
          {"wall_ms", update.wall_ms},
          {"volume_samples", update.samples},
          {"bit_identical", update.identical}};
}

io::Json as_json(const SkipBound& bound) {
  io::Json bricks = io::Json::array();
  for (const BrickOracle& one : bound.oracle.bricks) {
    bricks.push_back({{"edge", one.edge}, {"occupied", one.occupied}, {"samples", one.samples}});
  }
  return {{"scene", bound.found.scene},
          {"samples_first", bound.found.first},
          {"samples_on", bound.found.on},
          {"samples_off", bound.found.off},
          {"samples_brute", bound.found.brute},
          {"on_ms", bound.on_ms},
          {"off_ms", bound.off_ms},
          {"bit_identical", bound.found.identical},
          {"oracle_all", bound.oracle.all},
          {"oracle_opaque", bound.oracle.opaque},
          {"oracle_showing", bound.oracle.showing},
          {"bricks", std::move(bricks)}};
}

io::Json ratios_of(const BenchRenderReport& report) {
  const RenderBenchReport& comparison = report.comparison;
  io::Json json;
  json["cpu_vs_vtk_gpu_unshaded"] = summary(comparison, "cpu_vs_vtk_gpu", false);
  json["cpu_vs_vtk_gpu_shaded"] = summary(comparison, "cpu_vs_vtk_gpu", true);
  json["gl_vs_vtk_gpu"] = summary(comparison, "gl_vs_vtk_gpu", {});
  if (comparison.of_device) {
    json["gl_fragment_vs_vtk_gpu"] = summary(comparison, "gl-fragment_vs_vtk_gpu", {});
  }
  json["cpu_vs_vtk_gpu_any_unshaded"] = summary(comparison, "cpu_vs_vtk_gpu_any", false);
  json["cpu_vs_vtk_gpu_any_shaded"] = summary(comparison, "cpu_vs_vtk_gpu_any", true);
  json["gl_vs_vtk_gpu_any"] = summary(comparison, "gl_vs_vtk_gpu_any", {});
  json["cpu_dense_vs_vtk_gpu_unshaded"] = summary(comparison, "cpu_dense_vs_vtk_gpu", false);
  json["cpu_dense_vs_vtk_gpu_shaded"] = summary(comparison, "cpu_dense_vs_vtk_gpu", true);
  json["gl_dense_vs_vtk_gpu"] = summary(comparison, "gl_dense_vs_vtk_gpu", {});
  json["cpu_vs_vtk_fixedpoint"] = fixed_point_summary(comparison);
  json["samples_skip_off_over_on"] = skip_summary(report);
  json["cutaway_plane_fraction"] = report.cutaway ? as_json(*report.cutaway) : io::Json();
  json["image_update_ms"] = report.update ? as_json(*report.update) : io::Json();
  return json;
}

/// Sonde at the step and pixel error that it takes by itself against VTK's GPU mapper at its
/// default, one voxel.
io::Json default_quality(const RenderBenchReport& report) {
  io::Json rows = io::Json::array();
  for (const ChosenStep& chosen : report.chosen) {
    const double step = chosen.choice.step_voxels;
    const auto* ours =
        find_row(report, chosen.scene, "cpu", SparsePoint{step, chosen.choice.pixel_error});
    const auto* theirs = find_row(report, chosen.scene, "vtk-gpu", 1);
    if (!ours || !theirs) continue;
    const double fine_s = curve_of(report, chosen.scene, {{"cpu"}, true}).time_at(2e-3);
    rows.push_back({{"scene", chosen.scene},
                    {"step_voxels", step},
                    {"pixel_error", chosen.choice.pixel_error},
                    {"estimated_rms", chosen.choice.rms},
                    {"search_cpu_s", chosen.search_cpu_s},
                    {"rms", ours->rms},
                    {"rms_whole", chosen.rms_whole},
                    {"cpu_s", ours->cpu_s},
                    {"vtk_rms", theirs->error()},
                    {"vtk_cpu_s", theirs->cpu_s},
                    {"vtk_over_ours", theirs->cpu_s / ours->cpu_s},
                    {"cpu_s_at_2e-3", app::json_number(fine_s)},
                    {"vtk_over_ours_at_2e-3", app::json_number(theirs->cpu_s / fine_s)}});
  }
  return rows;
}

io::Json as_json(const Interaction& one) {
  return {{"scene", one.scene},
          {"side", one.side},
          {"step", one.step},
          {"pixel_error", one.pixel_error},
          {"rms", one.rms},
          {"dense_step", one.dense_step},
          {"dense_fps", 1e3 / one.dense_wall_ms},
          {"cpu_ms", one.cpu_ms},
          {"wall_ms", one.wall_ms},
          {"fps", 1e3 / one.wall_ms},
          {"progressive_wall_ms", one.progressive_wall_ms},
          {"progressive_fps", 1e3 / one.progressive_wall_ms},
          {"refined_ms", one.refined_ms}};
}

io::Json as_json(const CostTable& table) {
  io::Json elements = io::Json::array();
  for (const auto& cost : table.elements) {
    io::Json row{{"element", cost.element},
                 {"ms", cost.ms},
                 {"scatter_ms", cost.scatter_ms},
                 {"samples", cost.samples},
                 {"gradients", cost.gradients}};
    if (cost.has_idle) {
      row["idle_ms"] = cost.idle_ms;
      row["idle_scatter_ms"] = cost.idle_scatter_ms;
      row["idle_samples"] = cost.idle_samples;
      row["idle_gradients"] = cost.idle_gradients;
    }
    elements.push_back(std::move(row));
  }
  io::Json changes = io::Json::array();
  for (const auto& cost : table.changes) {
    changes.push_back({{"change", cost.change},
                       {"ms", cost.ms},
                       {"wall_ms", cost.wall_ms},
                       {"prepare_ms", cost.prepare_ms},
                       {"samples", cost.samples},
                       {"gradients", cost.gradients}});
  }
  io::Json preparations = io::Json::array();
  for (const auto& cost : table.preparations) {
    preparations.push_back({{"what", cost.what}, {"ms", cost.ms}, {"wall_ms", cost.wall_ms}});
  }
  return {{"frame_ms", table.frame_ms},
          {"frame_samples", table.frame_samples},
          {"elements", std::move(elements)},
          {"changes", std::move(changes)},
          {"preparations", std::move(preparations)}};
}

void add_comparison(const RenderBenchReport& report, io::Json& json) {
  json["gl_device"] = report.gl_device;
  json["time"] = report.of_device ? "wall" : "process";
  json["reference"] = {{"width", report.reference_width},
                       {"height", report.reference_height},
                       {"step", report.reference_step}};
  json["self_convergence"] = io::Json::object();
  for (const auto& truth : report.truths) {
    json["self_convergence"][truth.scene] = truth.self_convergence;
  }
  json["results"] = io::Json::array();
  for (const auto& row : report.rows) {
    json["results"].push_back({{"scene", row.scene},
                               {"engine", row.engine},
                               {"step", row.step},
                               {"pixel_error", row.pixel_error},
                               {"cpu_s", row.cpu_s},
                               {"wall_s", row.wall_s},
                               {"rms", row.rms},
                               {"max", row.max},
                               {"rms_own", app::json_number(row.rms_own)},
                               {"error", row.error()}});
  }
  json["equal_error"] = io::Json::array();
  for (const auto& ratio : report.ratios) {
    io::Json levels = io::Json::array();
    for (const auto& level : ratio.levels) {
      levels.push_back({{"rms", level.rms}, {"ratio", app::json_number(level.ratio)}});
    }
    json["equal_error"].push_back(
        {{"scene", ratio.scene}, {"name", ratio.name}, {"levels", std::move(levels)}});
  }
}

}  // namespace

io::Json json_of(const BenchRenderReport& report) {
  io::Json json;
  add_comparison(report.comparison, json);
  json["ratios"] = ratios_of(report);
  json["default_quality"] = default_quality(report.comparison);
  for (const char* key : {"interaction", "skip_bounds", "scene_costs"}) {
    json[key] = io::Json::array();
  }
  for (const char* key : {"transfer_function_edit", "costs"}) json[key] = nullptr;
  for (const auto& one : report.interaction) json["interaction"].push_back(as_json(one));
  for (const auto& one : report.skip_bounds) json["skip_bounds"].push_back(as_json(one));
  if (report.edit) {
    json["transfer_function_edit"] = {{"side", report.edit->side},
                                      {"prepare_ms", report.edit->prepare_ms},
                                      {"frame_ms", report.edit->frame_ms}};
  }
  if (report.costs) json["costs"] = as_json(*report.costs);
  for (const auto& [scene, costs] : report.scene_costs) {
    json["scene_costs"].push_back({{"scene", scene}, {"costs", as_json(costs)}});
  }
  return json;
}

io::Json json_of(const std::vector<ScalingPoint>& points) {
  io::Json json = io::Json::array();
  for (const auto& p : points) {
    json.push_back({{"axis", p.axis},
                    {"look", p.appearance},
                    {"x", p.x},
                    {"cpu_ms", p.cpu_ms},
                    {"wall_ms", p.wall_ms},
                    {"prepare_ms", p.prepare_ms},
                    {"samples", p.samples},
                    {"occupied", p.occupied},
                    {"bytes_per_voxel", app::json_number(p.bytes_per_voxel)}});
  }
  return json;
}

std::string live_text(const BenchRenderReport& report) {
  constexpr SkipMeasure kSkipping = &SkipRatio::ratio;
  constexpr SkipMeasure kAll = &SkipRatio::brute_ratio;
  std::ostringstream out;
  out << std::fixed << std::setprecision(1)
      << "\nVolume samples without skipping over with it: median " << median_skip(report, kSkipping)
      << " of " << report.skipping.size() << " scenes, vessels only "
      << median_skip(report, kSkipping, "vessels-only")
      << "; without early termination either, median " << median_skip(report, kAll)
      << ", vessels only " << median_skip(report, kAll, "vessels-only")
      << "; a volume that is nowhere empty takes " << 100 * report.full_volume_overhead
      << " % longer.\n"
      << "Plane and cutaway: " << 100 * report.cutaway->own_fraction()
      << " % of a frame for their own work (at most "
      << 100 * report.cutaway->own_fraction_at_most() << " %), "
      << 100 * report.cutaway->net_fraction() << " % with the samples they save; samples "
      << report.cutaway->ct_samples << " (CT), " << report.cutaway->plane_samples
      << " (and plane), " << report.cutaway->cutaway_samples << " (and cutaway).\n"
      << "New ultrasound image, same pose: " << std::setprecision(2) << report.update->wall_ms
      << " ms wall, " << report.update->cpu_ms << " ms process, " << report.update->samples
      << " volume samples, " << (report.update->identical ? "identical" : "NOT identical")
      << " to a full image.\n";
  if (report.edit) {
    out << "Transfer function edited at " << report.edit->side << "^3: " << report.edit->prepare_ms
        << " ms to classify anew, " << report.edit->frame_ms << " ms process for the next frame.\n";
  }
  for (const auto& one : report.interaction) {
    out << one.scene << " at " << one.side << "^3, step " << one.step << ", pixel error "
        << one.pixel_error << ", rms " << std::setprecision(4) << one.rms << std::setprecision(1)
        << ": " << 1e3 / one.wall_ms << " fps (" << one.cpu_ms << " process ms), progressive "
        << 1e3 / one.progressive_wall_ms << " fps, whole " << one.refined_ms
        << " ms after the last movement.\n";
  }
  return out.str();
}

std::string skip_text(const std::vector<SkipBound>& bounds) {
  std::ostringstream out;
  out << std::fixed
      << "\nVolume samples without skipping over: with it | bricks of 8^3 | 4^3 | 2^3 | "
         "cells | cells that show | behind opaque, % | occupied, %, of 8^3 | 4^3 | 2^3 | ms on | "
         "off\n";
  const auto over = [](std::uint64_t a, std::uint64_t b) {
    return static_cast<double>(a) / static_cast<double>(b > 0 ? b : 1);
  };
  for (const SkipBound& one : bounds) {
    const SkipOracle& oracle = one.oracle;
    const std::uint64_t off = oracle.all - oracle.opaque;
    out << std::setw(50) << std::left << one.found.scene << std::right << std::setprecision(2)
        << std::setw(7) << one.found.ratio();
    for (const auto& bricks : oracle.bricks) out << std::setw(7) << over(off, bricks.samples);
    out << std::setw(7) << over(off, oracle.showing) << std::setprecision(1) << std::setw(7)
        << 100 * over(oracle.opaque, oracle.all);
    for (const auto& bricks : oracle.bricks) out << std::setw(7) << 100 * bricks.occupied;
    out << std::setw(7) << one.on_ms << std::setw(7) << one.off_ms
        << (one.found.identical ? "\n" : " NOT the same bytes\n");
  }
  return out.str();
}

}  // namespace nav::bench
