// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "sim/ct_scanner.hpp"
#include "sim/procedure.hpp"

namespace nav::sim {
namespace {

const Procedure& procedure() {
  static const Procedure instance{ProcedureOptions{}};
  return instance;
}

/// Pictures of the default sweep, one after the other.
void BM_UltrasoundFrame(benchmark::State& state) {
  const UltrasoundSimulator simulator(procedure().phantom(), convex_abdominal(), 1);
  std::uint64_t sequence = 0;
  for (auto _ : state) {
    const Timestamp t = procedure().frame_time(static_cast<int>(sequence % 60));
    benchmark::DoNotOptimize(simulator.simulate(procedure().ct_from_image(t), t, sequence));
    ++sequence;
  }
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(sequence), benchmark::Counter::kIsRate);
}
BENCHMARK(BM_UltrasoundFrame)->Unit(benchmark::kMillisecond)->UseRealTime();

/// 640 x 480 pixels by an acoustic model; time is process CPU time.
void BM_UltrasoundFrame640(benchmark::State& state) {
  ProbeModel probe = convex_abdominal();
  probe.columns = 640;
  probe.rows = 480;
  probe.model = state.range(0) == 0 ? AcousticModel::kRays : AcousticModel::kScatterers;
  const UltrasoundSimulator simulator(procedure().phantom(), probe, 1);
  std::uint64_t sequence = 0;
  for (auto _ : state) {
    const Timestamp t = procedure().frame_time(static_cast<int>(sequence % 60));
    benchmark::DoNotOptimize(simulator.simulate(procedure().ct_from_image(t), t, sequence));
    ++sequence;
  }
}
BENCHMARK(BM_UltrasoundFrame640)
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();

/// The default scan: 201 x 161 x 111 voxels.
void BM_CtScan(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(scan_ct(procedure().phantom()));
}
BENCHMARK(BM_CtScan)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_BuildPhantom(benchmark::State& state) {
  std::uint64_t seed = 1;
  for (auto _ : state) benchmark::DoNotOptimize(AbdomenPhantom({seed++, Contrast::kPortal}));
}
BENCHMARK(BM_BuildPhantom)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace nav::sim
