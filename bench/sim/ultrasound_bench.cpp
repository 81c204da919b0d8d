// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "bench/measure.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/session/simulated_session.hpp"

namespace nav::sim {
namespace {

/// Ultrasound images of the default sweep, one after the other.
void BM_UltrasoundFrame(benchmark::State& state) {
  const UltrasoundSimulator simulator(AbdomenPhantom(), convex_abdominal(), 1);
  const SimulatedSession session = *SimulatedSession::create({});
  std::uint64_t sequence = 0;
  for (auto _ : state) {
    const ImageTruth truth = session.truth(static_cast<int>(sequence) % session.frame_count());
    benchmark::DoNotOptimize(simulator.simulate(truth.ct_from_image, truth.physical, sequence));
    ++sequence;
  }
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(sequence), benchmark::Counter::kIsRate);
}
BENCHMARK(BM_UltrasoundFrame)->Unit(benchmark::kMillisecond)->UseRealTime();

/// 640 x 480 pixels of the first view of a family, with that view's probe, by wall time. Images per
/// second ("frames/s"), and images per second of processor time ("frames/cpu_s").
void BM_UltrasoundFrame640(benchmark::State& state, const std::string& family,
                           AcousticModel model) {
  const auto patient = make_patient(family);
  StandardView view = patient->views.front();
  view.probe.columns = 640;
  view.probe.rows = 480;
  view.probe.model = model;
  const UltrasoundSimulator simulator(patient->anatomy, view.probe, 1);
  std::uint64_t sequence = 0;
  const double before = bench::process_time_s();
  for (auto _ : state) {
    benchmark::DoNotOptimize(simulator.simulate(view.ct_from_image, {}, sequence));
    ++sequence;
  }
  const auto frames = static_cast<double>(sequence);
  state.counters["frames/s"] = benchmark::Counter(frames, benchmark::Counter::kIsRate);
  state.counters["frames/cpu_s"] = frames / (bench::process_time_s() - before);
}

const bool kRegistered640 = [] {
  for (const PatientFamily& family : patient_families()) {
    for (const AcousticModel model : {AcousticModel::kRays, AcousticModel::kScatterers}) {
      const char* name = model == AcousticModel::kRays ? "rays" : "scatterers";
      benchmark::RegisterBenchmark(("UltrasoundFrame640/" + family.name + '/' + name).c_str(),
                                   BM_UltrasoundFrame640, family.name, model)
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    }
  }
  return true;
}();

/// The default scan: 201 x 161 x 111 voxels.
void BM_CtScan(benchmark::State& state) {
  const AbdomenPhantom phantom;
  for (auto _ : state) benchmark::DoNotOptimize(scan_ct(phantom));
}
BENCHMARK(BM_CtScan)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_BuildPhantom(benchmark::State& state) {
  std::uint64_t seed = 1;
  for (auto _ : state) benchmark::DoNotOptimize(AbdomenPhantom({seed++, Contrast::kPortal}));
}
BENCHMARK(BM_BuildPhantom)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace nav::sim
