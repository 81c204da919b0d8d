// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Ray casting of a synthetic abdomen on the CPU, 800 × 600. Times are of whole pictures with the
// caches warm; "prepare" is what a new volume or a new transfer function costs once.
#include <benchmark/benchmark.h>

#include "bench/support/synthetic_ct.hpp"
#include "render/engine.hpp"

namespace {

using namespace nav;
using namespace nav::render;

std::shared_ptr<const Volume> abdomen(int n) {
  static const auto small = test::SyntheticAbdomen::volume(128);
  static const auto large = test::SyntheticAbdomen::volume(256);
  return n == 128 ? small : large;
}

Scene scene_of(const char* preset, int n) {
  const Camera camera{{{-180, -620, 160}}, {{0, 0, 0}}, {{0, 0, 1}}};
  return {abdomen(n), *preset_transfer_function(preset), {}, {}, {}, {}, camera, {}};
}

void add_plane(Scene& scene) {
  constexpr int kWidth = 512;
  constexpr int kHeight = 400;
  UltrasoundFrame frame;
  frame.grid = PixelGrid::centred(kWidth, 0.3, 0.3);
  frame.pixels = {kWidth, kHeight, std::vector<std::uint8_t>(kWidth * kHeight, 128)};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
  scene.plane = UltrasoundPlane{frame, {turn, {-55, -100, 45}}, 1.0, {SafetyState::kValid, ""}};
}

void run(benchmark::State& state, Engine& engine, const Scene& scene) {
  auto image = engine.render(scene);  // Fills the caches.
  if (!image) return state.SkipWithError(image.error().message.c_str());
  const double prepare_s = image->statistics.prepare_s;
  for (auto _ : state) {
    image = engine.render(scene);
    benchmark::DoNotOptimize(image);
  }
  state.counters["prepare_ms"] = prepare_s * 1e3;
  state.counters["samples"] = static_cast<double>(image->statistics.volume_samples);
  state.counters["shaded"] = static_cast<double>(image->statistics.gradient_samples);
}

/// Arguments: voxels per side, shading, skipping.
void cast(benchmark::State& state, const char* preset, bool allow_vector) {
  const auto engine = make_cpu_engine({0, allow_vector});
  Scene scene = scene_of(preset, static_cast<int>(state.range(0)));
  scene.shading.enabled = state.range(1) != 0;
  scene.quality.skip_empty_bricks = state.range(2) != 0;
  run(state, *engine, scene);
}

/// One voxel per sample, as other renderers count by default.
void cast_one_voxel_step(benchmark::State& state) {
  const auto engine = make_cpu_engine();
  Scene scene = scene_of("ct-bone", static_cast<int>(state.range(0)));
  scene.quality.step_voxels = 1;
  run(state, *engine, scene);
}

/// The live plane in an invisible volume: what the plane itself costs.
void plane_only(benchmark::State& state) {
  const auto engine = make_cpu_engine();
  Scene scene = scene_of("ct-bone", 128);
  scene.transfer =
      *TransferFunction::create("nothing", {{-1024, {0, 0, 0}, 0, 0}, {3000, {0, 0, 0}, 0, 0}});
  add_plane(scene);
  run(state, *engine, scene);
}

void bone_with_plane(benchmark::State& state) {
  const auto engine = make_cpu_engine();
  Scene scene = scene_of("ct-bone", static_cast<int>(state.range(0)));
  add_plane(scene);
  run(state, *engine, scene);
}

void variants(benchmark::internal::Benchmark* b) {
  b->ArgNames({"voxels", "shaded", "skip"})->Unit(benchmark::kMillisecond)->UseRealTime();
  b->MeasureProcessCPUTime();
  for (const int n : {128, 256}) {
    b->Args({n, 0, 0})->Args({n, 0, 1})->Args({n, 1, 0})->Args({n, 1, 1});
  }
}
void sizes(benchmark::internal::Benchmark* b) {
  b->ArgName("voxels")->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
  b->Arg(128)->Arg(256);
}

BENCHMARK_CAPTURE(cast, bone, "ct-bone", true)->Apply(variants);
BENCHMARK_CAPTURE(cast, soft_tissue, "ct-soft-tissue", true)->Apply(variants);
BENCHMARK_CAPTURE(cast, vessels, "cta-vessels", true)->Apply(variants);
BENCHMARK_CAPTURE(cast, bone_portable, "ct-bone", false)->Apply(variants);
BENCHMARK(cast_one_voxel_step)->Apply(sizes);
BENCHMARK(plane_only)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
BENCHMARK(bone_with_plane)->Apply(sizes);

}  // namespace
