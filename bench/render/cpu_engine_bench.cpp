// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Ray casting of a synthetic abdomen on the CPU, 800 × 600. Times are those of whole images with
// warm caches; "prepare" is the single cost of a new volume or a new transfer function.
#include <benchmark/benchmark.h>

#include "render/engine.hpp"
#include "render/skipping/brick_grid.hpp"
#include "render/transfer/transfer_table.hpp"
#include "sim/synthetic_ct.hpp"

namespace {

using namespace nav;
using namespace nav::render;

std::shared_ptr<const Volume> abdomen(int n) {
  static const auto small = sim::SyntheticAbdomen::volume(128);
  static const auto large = sim::SyntheticAbdomen::volume(256);
  return n == 128 ? small : large;
}

Scene scene_of(const char* preset, int n) {
  const Camera camera{{{-180, -620, 160}}, {{0, 0, 0}}, {{0, 0, 1}}};
  return {.ct = abdomen(n), .transfer = *preset_transfer_function(preset), .camera = camera};
}

void add_plane(Scene& scene) {
  constexpr int kWidth = 512;
  constexpr int kHeight = 400;
  UltrasoundImage frame;
  frame.grid = PixelGrid::centred(kWidth, 0.3, 0.3);
  frame.pixels = {kWidth, kHeight, std::vector<std::uint8_t>(kWidth * kHeight, 128)};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
  scene.plane = UltrasoundPlane{frame, {turn, {-55, -100, 45}}, 1.0, {SafetyState::kValid, ""}};
}

/// The camera moves slightly from image to image, because an unchanged image is not drawn again.
void run(benchmark::State& state, Engine& engine, Scene scene) {
  auto image = engine.render(scene);  // Fills the caches.
  if (!image) return state.SkipWithError(image.error().message.c_str());
  const double prepare_s = image->statistics.prepare_s;
  const double eye_mm = scene.camera.eye_ct.mm.x();
  double moved_mm = 0;
  for (auto _ : state) {
    moved_mm = 1e-3 - moved_mm;
    scene.camera.eye_ct.mm.x() = eye_mm + moved_mm;
    image = engine.render(scene);
    benchmark::DoNotOptimize(image);
  }
  state.counters["prepare_ms"] = prepare_s * 1e3;
  state.counters["samples"] = static_cast<double>(image->statistics.volume_samples);
  state.counters["shaded"] = static_cast<double>(image->statistics.gradient_samples);
  state.counters["cut_rays"] = static_cast<double>(image->statistics.cutaway_rays);
  state.counters["faded"] = static_cast<double>(image->statistics.faded_cells);
}

/// Arguments: voxels per side, shading, skipping.
void cast(benchmark::State& state, const char* preset, CpuLanes lanes) {
  const auto engine = make_cpu_engine({0, lanes});
  Scene scene = scene_of(preset, static_cast<int>(state.range(0)));
  scene.shading.enabled = state.range(1) != 0;
  scene.quality.skip_empty_bricks = state.range(2) != 0;
  run(state, *engine, scene);
}

/// The default step of other renderers, with either classification. Argument: pre-integrated.
void cast_one_voxel_step(benchmark::State& state) {
  const auto engine = make_cpu_engine();
  Scene scene = scene_of("ct-soft-tissue", 256);
  scene.quality.step_voxels = 1;
  if (state.range(0) == 0) scene.quality.classification = Classification::kPostClassified;
  run(state, *engine, scene);
}

/// Gooch shading with half of the emphasis.
void gooch(benchmark::State& state) {
  const auto engine = make_cpu_engine();
  Scene scene = scene_of("ct-soft-tissue", static_cast<int>(state.range(0)));
  scene.shading.style = ShadingStyle::kGooch;
  scene.shading.emphasis = 0.5;
  run(state, *engine, scene);
}

/// Fog everywhere, so that nothing can be skipped. Argument: skipping.
void full_volume(benchmark::State& state) {
  const auto engine = make_cpu_engine();
  Scene scene = scene_of("ct-bone", 256);
  scene.shading.enabled = false;
  scene.transfer =
      *TransferFunction::create("fog", {{-1024, {1, 0, 0}, 1e-4, 0}, {3000, {0, 1, 0}, 1e-4, 0}});
  scene.quality.skip_empty_bricks = state.range(0) != 0;
  run(state, *engine, scene);
}

void projection(benchmark::State& state, Projection kind) {
  const auto engine = make_cpu_engine();
  Scene scene = scene_of("ct-bone", 256);
  scene.quality.step_voxels = 1;
  scene.projection = kind;
  run(state, *engine, scene);
}

/// An edit of the transfer function at 384³: visibility and importance of 48³ bricks, distances,
/// depths, visibility of parts.
void reclassify(benchmark::State& state, const char* preset) {
  static const auto ct = sim::SyntheticAbdomen::volume(384);
  static const BrickGrid grid = make_brick_grid(*ct, 0);
  static const BrickGrid parts = make_part_grid(*ct, 0);
  const TransferTable table(*preset_transfer_function(preset));
  for (auto _ : state) {
    const std::vector<std::uint8_t> hidden = hidden_bricks(grid, table);
    benchmark::DoNotOptimize(brick_distances(grid, hidden));
    benchmark::DoNotOptimize(visible_parts(parts, grid, hidden, table));
    benchmark::DoNotOptimize(brick_depths(grid, hidden));
    benchmark::DoNotOptimize(brick_importance(grid, table));
  }
}

/// The live plane in an invisible volume: the cost of the plane itself.
void plane_only(benchmark::State& state) {
  const auto engine = make_cpu_engine();
  Scene scene = scene_of("ct-bone", 128);
  scene.transfer =
      *TransferFunction::create("nothing", {{-1024, {0, 0, 0}, 0, 0}, {3000, {0, 0, 0}, 0, 0}});
  add_plane(scene);
  run(state, *engine, scene);
}

/// Arguments: plane, and cutaway around it.
void with_plane(benchmark::State& state, const char* preset) {
  const auto engine = make_cpu_engine();
  Scene scene = scene_of(preset, 256);
  scene.quality.step_voxels = 1;
  if (state.range(0) != 0) add_plane(scene);
  if (state.range(1) != 0) scene.cutaway.emplace();
  run(state, *engine, scene);
}

void variants(benchmark::internal::Benchmark* b) {
  b->ArgNames({"voxels", "shaded", "skip"})->Unit(benchmark::kMillisecond)->UseRealTime();
  b->MeasureProcessCPUTime();
  for (const int n : {128, 256}) {
    b->Args({n, 0, 0})->Args({n, 0, 1})->Args({n, 1, 0})->Args({n, 1, 1});
  }
}
void planes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"plane", "cutaway"})->Unit(benchmark::kMillisecond)->UseRealTime();
  b->MeasureProcessCPUTime()->Args({0, 0})->Args({1, 0})->Args({1, 1});
}
void sizes(benchmark::internal::Benchmark* b) {
  b->ArgName("voxels")->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
  b->Arg(128)->Arg(256);
}

BENCHMARK_CAPTURE(cast, bone, "ct-bone", CpuLanes::kFastest)->Apply(variants);
BENCHMARK_CAPTURE(cast, soft_tissue, "ct-soft-tissue", CpuLanes::kFastest)->Apply(variants);
BENCHMARK_CAPTURE(cast, vessels, "cta-vessels", CpuLanes::kFastest)->Apply(variants);
BENCHMARK_CAPTURE(cast, bone_avx2, "ct-bone", CpuLanes::kAvx2)->Apply(variants);
BENCHMARK_CAPTURE(cast, soft_tissue_avx2, "ct-soft-tissue", CpuLanes::kAvx2)->Apply(variants);
BENCHMARK_CAPTURE(cast, vessels_avx2, "cta-vessels", CpuLanes::kAvx2)->Apply(variants);
BENCHMARK_CAPTURE(cast, bone_portable, "ct-bone", CpuLanes::kPortable)->Apply(variants);
BENCHMARK(cast_one_voxel_step)
    ->ArgName("pre_integrated")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK(gooch)->Apply(sizes);
BENCHMARK(full_volume)
    ->ArgName("skip")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(projection, maximum, Projection::kMaximum)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(projection, mean, Projection::kMean)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(reclassify, soft_tissue, "ct-soft-tissue")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(reclassify, vessels, "cta-vessels")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK(plane_only)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(with_plane, vessels, "cta-vessels")->Apply(planes);
BENCHMARK_CAPTURE(with_plane, soft_tissue, "ct-soft-tissue")->Apply(planes);

}  // namespace
