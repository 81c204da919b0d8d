// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <iterator>

#include "app/appearance/appearance.hpp"
#include "app/engines.hpp"
#include "app/report.hpp"
#include "app/views/presenter.hpp"
#include "bench/scene_set.hpp"
#include "bench/verbs/bench_json.hpp"
#include "bench/whole_scene.hpp"
#include "io/ct.hpp"
#include "sim/session/simulated_session.hpp"

namespace nav::bench {
namespace {

/// Difference of two images of the same scene, in 8-bit steps.
struct Difference {
  double share_above_two;  ///< Share of pixels whose largest channel differs by more than 2.
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

/// The demo's image in the middle of its approach: CT, live plane, needle, target.
Result<render::Scene> demo_scene(std::shared_ptr<const Volume> ct,
                                 const sim::SimulatedSession& simulation, int width, int height) {
  app::PresenterOptions options;
  options.appearance.preset = "cta-vessels";
  options.width = width;
  options.height = height;
  auto presenter = app::Presenter::create(options, std::move(ct), render::make_cpu_engine());
  if (!presenter) return presenter.error();
  const NeedlePlan plan = simulation.needle()->plan();
  const sim::ProbeModel& probe = simulation.options().probe;
  presenter->set_facts(
      {.plan = plan,
       .focus_ct = plan.target_ct,
       .typical_plane = app::SessionFacts::TypicalPlane{
           simulation.truth(simulation.frame_count() - 1).ct_from_image, probe.depth_mm}});
  const auto& approach = simulation.phases().back();
  const sim::ImageTruth middle = simulation.truth(approach.first_frame + approach.frame_count / 2);
  const sim::UltrasoundSimulator simulator(sim::AbdomenPhantom(), probe, 1);
  session::Epoch epoch;
  epoch.now = middle.physical;
  epoch.ct_from_image = middle.ct_from_image;
  epoch.ct_from_needle = middle.needle->ct_from_needle;
  epoch.frame = TrackedImage{
      simulator.simulate(middle.ct_from_image, middle.physical, 0, epoch.ct_from_needle),
      simulation.ct_from_reference().inverse() * middle.ct_from_image, Duration::zero()};
  epoch.plane = epoch.needle = epoch.ultrasound = epoch.placement = {SafetyState::kValid, ""};
  render::Scene scene = presenter->scene(epoch);
  scene.lines.push_back({plan.entry_ct, plan.target_ct});
  scene.cutaway = render::Cutaway{};
  return scene;
}

Result<io::Json> agreement(const render::Scene& scene, app::Console& console) {
  auto reference = render::make_reference_engine();
  const auto truth = reference->render(scene);
  if (!truth) return truth.error();
  io::Json rows = io::Json::array();
  std::printf("\n%-10s %22s %10s %10s   against the reference at the same step\n", "engine",
              "pixels within 2/255", "max /255", "rms /255");
  for (const char* name : {"cpu", "gl"}) {
    auto engine = app::make_engine(name, 0, console);
    if (!engine) {
      console.report(Severity::kWarning, "bench", engine.error().message);
      continue;
    }
    const auto image = (*engine)->render(scene);
    if (!image) return image.error();
    const Difference d = compare(render::to_8bit(image->pixels), render::to_8bit(truth->pixels));
    std::printf("%-10s %20.4f %% %10d %10.3f\n", name, 100 * (1 - d.share_above_two), d.max, d.rms);
    rows.push_back({{"engine", name},
                    {"share_within_2_of_255", 1 - d.share_above_two},
                    {"max_of_255", d.max},
                    {"rms_of_255", d.rms}});
  }
  return rows;
}

/// The scenes to compare in: of the user's CT, or of the set; there may be none.
Result<std::vector<NamedScene>> scenes_of_set(const BenchRenderOptions& options, int width,
                                              int height, app::Console& console) {
  std::vector<BenchVolume> volumes;
  if (!options.ct.empty()) {
    auto ct = io::read_ct(options.ct, console);
    if (!ct) return ct.error();
    auto volume =
        bench_volume(options.ct.stem().string(), std::make_shared<const Volume>(std::move(*ct)));
    if (!volume) return volume.error();
    volumes.push_back(std::move(*volume));
  } else {
    auto set = bench_volumes(options.scene, bench_data_dir(), console);
    if (!set) return set.error();
    volumes = std::move(*set);
  }
  return bench_scenes(volumes, options.scene, width, height);
}

Result<void> expect_some(const std::vector<NamedScene>& scenes, const BenchRenderOptions& options) {
  if (!scenes.empty()) return {};
  return Error{ErrorCode::kUsage,
               "--scene: expected part of a name like "
               "simulated-patient/cta-vessels/perspective/shaded, found " +
                   options.scene};
}

/// One scene of each volume, another appearance, camera and shading each time.
std::vector<NamedScene> stratified(const std::vector<NamedScene>& scenes) {
  std::vector<NamedScene> few;
  std::string volume;
  std::size_t in_volume = 0;
  std::size_t volumes = 0;
  for (const auto& named : scenes) {
    const std::string of = named.name.substr(0, named.name.find('/'));
    if (of != volume) {
      volume = of;
      in_volume = 0;
      ++volumes;
    }
    // Eight scenes a volume: look, camera and shading are the bits of the index.
    constexpr std::array<std::size_t, 4> kWhich{0, 7, 5, 2};
    if (in_volume++ == kWhich[(volumes - 1) % kWhich.size()]) few.push_back(named);
  }
  // Some of either shading, so that no ratio is missing.
  for (const bool shaded : {false, true}) {
    const auto is_so = [&](const NamedScene& named) {
      return named.scene.shading.enabled == shaded;
    };
    if (std::any_of(few.begin(), few.end(), is_so)) continue;
    const auto found = std::find_if(scenes.begin(), scenes.end(), is_so);
    if (found != scenes.end()) few.push_back(*found);
  }
  return few;
}

/// Samples are counted on images of 200 x 150 pixels.
Result<void> add_skipping(NamedScene named, BenchRenderReport& report) {
  named.scene.width = 200;
  named.scene.height = 150;
  auto skip = measure_skipping(named);
  if (!skip) return skip.error();
  report.skipping.push_back(std::move(*skip));
  return {};
}

/// Camera and shading of the scenes about a cubic patient.
constexpr const char* kMotionView = "perspective/shaded";

std::vector<render::TransferFunction> motion_looks() {
  std::vector<render::TransferFunction> all;
  for (const char* preset : {"ct-bone", "cta-vessels"}) {
    all.push_back(*render::preset_transfer_function(preset));
  }
  all.push_back(vessels_only());
  return all;
}

/// The patient by the default appearance, with plane, needle, target, path and cutaway, 800 × 600.
Result<NamedScene> contextual_scene(const std::shared_ptr<const Volume>& ct) {
  const app::SessionConfig::Appearance appearance;
  auto resolved = app::resolve_appearance(appearance, *ct);
  if (!resolved) return resolved.error();
  const std::vector<render::TransferFunction> transfers{resolved->transfer};
  auto scenes = bench_scenes({{"patient-256", ct, transfers}}, kMotionView, 800, 600);
  if (scenes.empty()) {
    return Error{ErrorCode::kNotFound,
                 "bench: expected a scene of the default appearance, found none"};
  }
  NamedScene one = std::move(scenes.front());
  one.scene = with_everything(std::move(one.scene));
  one.scene.shading = resolved->shading;
  if (resolved->cutaway) one.scene.cutaway = resolved->cutaway;
  if (resolved->drawn) {
    one.scene.ct = resolved->drawn->ct;
    one.scene.transfer = resolved->drawn->transfer;
    one.scene.gradient_source = resolved->drawn->gradient_source;
  }
  one.name += "/cutaway";
  return one;
}

/// The camera moves about a cubic patient; the last scene's volume also sees an edit.
Result<void> measure_motion(bool quick, BenchRenderReport& report, app::Console& console) {
  const auto appearances = motion_looks();
  const std::vector<int> sides = quick ? std::vector<int>{256} : std::vector<int>{256, 384};
  for (const int side : sides) {
    auto ct = cubic_patient(side);
    if (!ct) return ct.error();
    const auto scenes = bench_scenes({{"patient-" + std::to_string(side), *ct, appearances}},
                                     kMotionView, 800, 600);
    if (side == sides.front()) {
      auto contextual = contextual_scene(*ct);
      if (!contextual) return contextual.error();
      auto moved = measure_interaction(*contextual, {quick ? 3 : 7, 3});
      if (!moved) return moved.error();
      report.interaction.push_back(std::move(*moved));
    }
    for (const auto& named : scenes) {
      console.progress(static_cast<double>(report.interaction.size()) /
                       static_cast<double>(sides.size() * appearances.size() + 1));
      auto moved = measure_interaction(named, {quick ? 3 : 7, 3});
      if (!moved) return moved.error();
      report.interaction.push_back(std::move(*moved));
      if (auto ok = add_skipping(named, report); !ok) return ok;
    }
    auto edit = measure_edit(scenes.front().scene, 5);
    if (!edit) return edit.error();
    report.edit = *edit;
  }
  return {};
}

/// Measures the costs of the navigation scene: always cutaway and update, and those of every
/// element if the options ask for them.
Result<void> measure_navigation(const render::Scene& scene, const std::shared_ptr<const Volume>& ct,
                                const BenchRenderOptions& options, BenchRenderReport& report) {
  const Repeats repeats{options.quick ? 3 : 9, 3};
  render::Scene large = scene;
  large.width = 800;
  large.height = 600;
  auto cutaway = measure_cutaway(large, repeats);
  if (!cutaway) return cutaway.error();
  report.cutaway = *cutaway;
  auto update = measure_image_update(large, options.quick ? 3 : 7);
  if (!update) return update.error();
  report.update = *update;
  auto overhead = full_volume_overhead(scene, repeats);
  if (!overhead) return overhead.error();
  report.full_volume_overhead = *overhead;
  if (!options.costs) return {};
  if (options.quick) {
    large.width = 400;
    large.height = 300;
  }
  auto costs = measure_costs(large, repeats);
  if (!costs) return costs.error();
  report.costs = std::move(*costs);
  auto preparations = measure_preparations(ct, {options.quick ? 1 : 5, 20});
  if (!preparations) return preparations.error();
  report.costs->preparations = std::move(*preparations);
  return {};
}

Result<void> measure_comparison(const BenchRenderOptions& options, int width, int height,
                                BenchRenderReport& report, app::Console& console) {
  RenderBenchOptions bench_options;
  if (options.quick) {
    bench_options.repeats = {1, 0};
    bench_options.reference_width = 40;
    bench_options.reference_height = 30;
  }
  if (auto ok = check_image(bench_options, width, height); !ok) return ok;
  console.begin("volumes");
  auto scenes = scenes_of_set(options, width, height, console);
  if (!scenes) return scenes.error();
  if (const auto ok = expect_some(*scenes, options); !ok) return ok;
  console.end();
  console.begin("skipping");
  for (const auto& named : *scenes) {
    if (auto ok = add_skipping(named, report); !ok) return ok;
    console.progress(static_cast<double>(report.skipping.size()) /
                     static_cast<double>(scenes->size()));
  }
  console.end();
  if (options.quick) *scenes = stratified(*scenes);
  console.begin("engines side by side");
  auto compared = compare_renderers(*scenes, bench_options, console, [&](std::size_t done) {
    console.progress(static_cast<double>(done) / static_cast<double>(scenes->size()));
  });
  if (!compared) return compared.error();
  report.comparison = std::move(*compared);
  console.end();
  std::cout << to_text(report.comparison) << std::flush;
  return {};
}

/// Measures the skipped samples in the scenes of the set and around a cubic patient, beside those
/// that could be skipped.
Result<void> measure_skip_bounds(const BenchRenderOptions& options, BenchRenderReport& report,
                                 app::Console& console) {
  constexpr int kWidth = 200;
  constexpr int kHeight = 150;
  console.begin("skipping");
  auto scenes = scenes_of_set(options, kWidth, kHeight, console);
  if (!scenes) return scenes.error();
  constexpr double kCoarselyMm = 4.8;
  const std::vector<int> sides = options.quick ? std::vector{64} : std::vector{256, 384};
  for (const int side : sides) {
    const std::string patient = "patient-" + std::to_string(side);
    auto appearances = motion_looks();
    std::erase_if(appearances, [&](const render::TransferFunction& appearance) {
      const std::string name = patient + "/" + appearance.name() + "/" + kMotionView;
      return name.find(options.scene) == std::string::npos;
    });
    if (appearances.empty()) continue;  // To make the patient takes seconds.
    auto ct = options.quick ? cubic_patient(side, kCoarselyMm) : cubic_patient(side);
    if (!ct) return ct.error();
    auto more = bench_scenes({{patient, *ct, appearances}}, kMotionView, kWidth, kHeight);
    std::ranges::move(more, std::back_inserter(*scenes));
  }
  if (const auto ok = expect_some(*scenes, options); !ok) return ok;
  for (const auto& named : *scenes) {
    auto bound = measure_skip_bound(named, options.quick ? 1 : 5);
    if (!bound) return bound.error();
    report.skip_bounds.push_back(std::move(*bound));
    console.progress(static_cast<double>(report.skip_bounds.size()) /
                     static_cast<double>(scenes->size()));
  }
  console.end();
  std::cout << skip_text(report.skip_bounds);
  return {};
}

/// Measures the cost of each element in the scenes of the set.
Result<void> measure_scene_costs(const BenchRenderOptions& options, int width, int height,
                                 BenchRenderReport& report, app::Console& console) {
  console.begin("costs");
  auto scenes = scenes_of_set(options, width, height, console);
  if (!scenes) return scenes.error();
  if (const auto ok = expect_some(*scenes, options); !ok) return ok;
  const Repeats repeats{options.quick ? 3 : 9, 3};
  for (const auto& named : *scenes) {
    auto costs = measure_costs(with_everything(named.scene), repeats);
    if (!costs) return costs.error();
    report.scene_costs.push_back({named.name, std::move(*costs)});
    console.progress(static_cast<double>(report.scene_costs.size()) /
                     static_cast<double>(scenes->size()));
  }
  console.end();
  for (const auto& [scene, costs] : report.scene_costs) {
    std::cout << '\n' << scene << "\n\n" << to_text(costs);
  }
  return {};
}

/// Measures the demands of a live session; returns the agreement of the engines on its scene.
Result<io::Json> measure_live(const BenchRenderOptions& options, int width, int height,
                              BenchRenderReport& report, app::Console& console) {
  console.begin("a live session");
  sim::SimulatedSessionOptions with_approach;
  with_approach.approach.emplace();
  const auto simulation = sim::SimulatedSession::create(with_approach);
  if (!simulation) return simulation.error();
  auto ct = simulated_ct();
  if (!ct) return ct.error();
  const auto scene = demo_scene(*ct, *simulation, width, height);
  if (!scene) return scene.error();
  if (auto ok = measure_navigation(*scene, *ct, options, report); !ok) return ok.error();
  console.end();
  console.begin("a moving camera");
  if (auto ok = measure_motion(options.quick, report, console); !ok) return ok.error();
  console.end();
  std::cout << live_text(report);
  if (report.costs) std::cout << '\n' << to_text(*report.costs);

  console.begin("agreement with the reference");
  auto rows = agreement(*scene, console);
  console.end();
  return rows;
}

}  // namespace

bool asks_for(const std::vector<std::string>& parts, const std::string& part) {
  return parts.empty() || names_part(parts, part);
}

bool names_part(const std::vector<std::string>& parts, const std::string& part) {
  return std::find(parts.begin(), parts.end(), part) != parts.end();
}

Result<void> run_bench_render(const BenchRenderOptions& options, app::Console& console) {
  const int width = options.quick ? 200 : options.width;
  const int height = options.quick ? 150 : options.height;
  BenchRenderReport report;
  io::Json agreements;
  if (asks_for(options.parts, "compare")) {
    if (auto ok = measure_comparison(options, width, height, report, console); !ok) return ok;
  }
  if (asks_for(options.parts, "live")) {
    auto rows = measure_live(options, width, height, report, console);
    if (!rows) return rows.error();
    agreements = std::move(*rows);
  }
  if (names_part(options.parts, "costs")) {
    if (auto ok = measure_scene_costs(options, width, height, report, console); !ok) return ok;
  }
  if (names_part(options.parts, "skipping")) {
    if (auto ok = measure_skip_bounds(options, report, console); !ok) return ok;
  }
  if (!options.json) return {};
  io::Json json;
  json["verb"] = "bench render";
  json["version"] = SONDE_VERSION;
  json["quick"] = options.quick;
  json["width"] = width;
  json["height"] = height;
  json.update(json_of(report));
  json["agreement"] = std::move(agreements);
  return app::write_json(json, *options.json);
}

Result<void> run_bench_scaling(const BenchScalingOptions& options, app::Console& console) {
  ScalingOptions scaling;
  std::erase_if(scaling.sides, [&](int side) { return side > options.largest; });
  scaling.side = std::min(scaling.side, options.largest);
  console.begin("scaling");
  const auto points = measure_scaling(scaling, [&](double done) { console.progress(done); });
  if (!points) return points.error();
  console.end();
  std::cout << to_text(*points) << std::flush;
  if (!options.json) return {};
  io::Json json;
  json["verb"] = "bench scaling";
  json["version"] = SONDE_VERSION;
  json["points"] = json_of(*points);
  return app::write_json(json, *options.json);
}

}  // namespace nav::bench
