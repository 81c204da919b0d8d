// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <cmath>
#include <random>

#include "registration/similarity/lc2_kernel.hpp"

namespace nav::registration {
namespace {

/// 160³ texels (65 MB): larger than any cache, as in real use.
const CtChannels& channels() {
  static const CtChannels instance = [] {
    CtChannels ct;
    ct.size = {160, 160, 160};
    ct.spacing_mm = {1, 1, 1};
    ct.origin_ct_mm = {0, 0, 0};
    ct.directions.setIdentity();
    std::mt19937 random(1);
    const auto noise = [&] { return static_cast<float>(random()) / 4294967296.0f; };
    for (int i = 0; i < 160 * 160 * 160; ++i) {
      const float f = noise();
      const float x = noise();
      const float y = noise();
      ct.texels.push_back({f, x, y, noise()});
    }
    return ct;
  }();
  return instance;
}

template <class Evaluate>
void run(benchmark::State& state, Evaluate evaluate) {
  const int side = static_cast<int>(state.range(0));
  const auto count = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  std::vector<float> u(count);
  for (std::size_t i = 0; i < count; ++i) u[i] = std::sin(static_cast<float>(i));
  PlacedPatch patch{.centre = {0, 0, 0},
                    .step_a = {0.8, 0.1, 0},
                    .step_b = {0, 0.7, 0.4},
                    .beam = {0, 0.87, 0.5},
                    .side = side,
                    .u = u};
  std::mt19937 random(2);
  benchmark::DoNotOptimize(channels().texels.data());  // Made before the measurement starts.
  for (auto _ : state) {
    for (int axis = 0; axis < 3; ++axis) {
      patch.centre[axis] = 20 + 120 * (static_cast<double>(random()) / 4294967296.0);
    }
    evaluate(patch);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
  state.counters["ns_per_sample"] = benchmark::Counter(
      1e-9 * static_cast<double>(state.iterations()) * static_cast<double>(count),
      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void kernel_cost(benchmark::State& state) {
  run(state, [](const PlacedPatch& patch) {
    benchmark::DoNotOptimize(patch_cost(channels(), patch, 0.02));
  });
}
BENCHMARK(kernel_cost)->Arg(7)->Arg(13);

void kernel_with_derivatives(benchmark::State& state) {
  run(state, [](const PlacedPatch& patch) {
    const PatchTerms terms = patch_terms(channels(), patch, 0.02);
    benchmark::DoNotOptimize(terms.s);
  });
}
BENCHMARK(kernel_with_derivatives)->Arg(7)->Arg(13);

}  // namespace
}  // namespace nav::registration
