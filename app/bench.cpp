// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/bench.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

#include "app/engines.hpp"
#include "app/presenter.hpp"
#include "app/report.hpp"
#include "bench/render_comparison.hpp"
#include "io/ct.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/procedure.hpp"

namespace nav::app {
namespace {

/// How far two pictures of the same scene are apart, in 8-bit steps.
struct Difference {
  double share_above_two;  ///< Of pixels whose largest channel differs by more than 2.
  int max;
  double rms;
};

Difference compare(const Image2d<Rgba8>& a, const Image2d<Rgba8>& b) {
  std::size_t above = 0;
  int max = 0;
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    const Rgba8& p = a.pixels()[i];
    const Rgba8& q = b.pixels()[i];
    const int d[] = {std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)};
    const int worst = *std::max_element(d, d + 3);
    above += worst > 2 ? 1 : 0;
    max = std::max(max, worst);
    for (const int one : d) sum += one * one;
  }
  const auto count = static_cast<double>(a.pixels().size());
  return {static_cast<double>(above) / count, max, std::sqrt(sum / (3 * count))};
}

/// The demo's picture in the middle of its approach: CT, live plane, needle, target.
Result<render::Scene> demo_scene(std::shared_ptr<const Volume> ct, const sim::Procedure& procedure,
                                 int width, int height) {
  PresenterOptions options;
  options.look.preset = "cta-vessels";
  options.width = width;
  options.height = height;
  auto presenter = Presenter::create(options, std::move(ct), render::make_cpu_engine());
  if (!presenter) return presenter.error();
  presenter->set_plan(procedure.plan());
  presenter->set_focus(procedure.plan().target_ct);
  presenter->set_typical_plane(procedure.ct_from_image(procedure.end()),
                               procedure.options().probe.depth_mm);
  const auto& approach = procedure.phases().back();
  const Timestamp middle = procedure.frame_time(approach.first_frame + approach.frame_count / 2);
  const sim::UltrasoundSimulator simulator(procedure.phantom(), procedure.options().probe, 1);
  Epoch epoch;
  epoch.now = middle;
  epoch.ct_from_image = procedure.ct_from_image(middle);
  epoch.ct_from_needle = procedure.ct_from_needle(middle);
  epoch.frame = TrackedFrame{
      simulator.simulate(*epoch.ct_from_image, middle, 0, epoch.ct_from_needle),
      procedure.ct_from_reference().inverse() * *epoch.ct_from_image, Duration::zero(), false};
  epoch.plane = epoch.needle = epoch.ultrasound = epoch.placement = {SafetyState::kValid, ""};
  return presenter->scene(epoch);
}

Result<Json> agreement(const render::Scene& scene, Console& console) {
  auto reference = render::make_reference_engine();
  const auto truth = reference->render(scene);
  if (!truth) return truth.error();
  Json rows = Json::array();
  std::printf("\n%-10s %22s %10s %10s   against the reference at the same step\n", "engine",
              "pixels within 2/255", "max /255", "rms /255");
  for (const char* name : {"cpu", "gl"}) {
    auto engine = make_engine(name, 0, console);
    if (!engine) {
      console.report(Severity::kWarning, "bench", engine.error().message);
      continue;
    }
    const auto picture = (*engine)->render(scene);
    if (!picture) return picture.error();
    const Difference d = compare(render::to_8bit(picture->pixels), render::to_8bit(truth->pixels));
    std::printf("%-10s %20.4f %% %10d %10.3f\n", name, 100 * (1 - d.share_above_two), d.max, d.rms);
    rows.push_back({{"engine", name},
                    {"share_within_2_of_255", 1 - d.share_above_two},
                    {"max_of_255", d.max},
                    {"rms_of_255", d.rms}});
  }
  return rows;
}

Result<std::vector<bench::NamedScene>> comparison_scenes(const BenchRenderOptions& options,
                                                         std::shared_ptr<const Volume> ct,
                                                         const std::string& ct_name, int width,
                                                         int height) {
  std::vector<bench::NamedScene> scenes;
  for (const char* preset : {"ct-bone", "cta-vessels", "ct-soft-tissue"}) {
    for (const bool shaded : {false, true}) {
      const std::string name = ct_name + "/" + preset + (shaded ? "/shaded" : "/unshaded");
      if (!options.scene.empty() && options.scene != name) continue;
      PresenterOptions look;
      look.look.preset = preset;
      look.look.shading = shaded;
      look.width = width;
      look.height = height;
      auto presenter = Presenter::create(look, ct, render::make_cpu_engine());
      if (!presenter) return presenter.error();
      scenes.push_back({name, presenter->scene(Epoch{})});
    }
  }
  if (scenes.empty()) {
    return Error{ErrorCode::kUsage, "--scene: expected a name like " + ct_name +
                                        "/ct-bone/shaded, found " + options.scene};
  }
  return scenes;
}

Json json_of(const bench::RenderBenchReport& report) {
  Json json;
  json["gl_device"] = report.gl_device;
  json["results"] = Json::array();
  for (const auto& row : report.rows) {
    json["results"].push_back({{"scene", row.scene},
                               {"engine", row.engine},
                               {"step", row.step},
                               {"cpu_s", row.cpu_s},
                               {"wall_s", row.wall_s},
                               {"rms", row.rms},
                               {"max", row.max}});
  }
  json["ratios"] = Json::array();
  for (const auto& ratio : report.ratios) {
    json["ratios"].push_back({{"scene", ratio.scene},
                              {"name", ratio.name},
                              {"step", ratio.step},
                              {"same_step", json_number(ratio.same_step)},
                              {"equal_error", json_number(ratio.equal_error)}});
  }
  return json;
}

}  // namespace

Result<void> run_bench_render(const BenchRenderOptions& options, Console& console) {
  const int width = options.quick ? 200 : options.width;
  const int height = options.quick ? 150 : options.height;
  console.begin("volumes");
  const sim::Procedure procedure(sim::ProcedureOptions{});
  auto phantom_ct = sim::scan_ct(procedure.phantom());
  if (!phantom_ct) return phantom_ct.error();
  const auto simulated = std::make_shared<const Volume>(std::move(*phantom_ct));
  auto compared = simulated;
  std::string ct_name = "simulated-patient";
  if (!options.ct.empty()) {
    auto ct = io::read_ct(options.ct, console);
    if (!ct) return ct.error();
    compared = std::make_shared<const Volume>(std::move(*ct));
    ct_name = options.ct.stem().string();
  }
  console.end();

  auto scenes = comparison_scenes(options, compared, ct_name, width, height);
  if (!scenes) return scenes.error();
  bench::RenderBenchOptions bench_options;
  if (options.quick) {
    bench_options.step_voxels = {1, 0.5};
    bench_options.frames = 1;
    bench_options.reference_width = 40;
    bench_options.reference_height = 30;
    while (scenes->size() > 2) scenes->pop_back();
  }
  console.begin("engines side by side");
  const auto report = bench::compare_renderers(*scenes, bench_options, console);
  if (!report) return report.error();
  console.end();
  std::cout << bench::to_text(*report) << std::flush;

  console.begin("agreement with the reference");
  const auto scene = demo_scene(simulated, procedure, width, height);
  if (!scene) return scene.error();
  auto rows = agreement(*scene, console);
  if (!rows) return rows.error();
  console.end();
  if (!options.json) return {};
  Json json;
  json["verb"] = "bench render";
  json["version"] = SONDE_VERSION;
  json["quick"] = options.quick;
  json["width"] = width;
  json["height"] = height;
  json.update(json_of(*report));
  json["agreement"] = std::move(*rows);
  return write_json(json, *options.json);
}

}  // namespace nav::app
