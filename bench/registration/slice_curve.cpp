// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/slice_curve.hpp"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "bench/measure.hpp"
#include "bench/registration/summary.hpp"
#include "bench/registration/thread_time.hpp"
#include "nav/check.hpp"
#include "nav/index.hpp"
#include "sim/ct_scanner.hpp"

namespace nav::bench {
namespace {

using registration::PreparedCt;
using registration::PreparedSweep;

constexpr double kSliceStartMm = 5;

/// Results of the registrations with one thickness.
struct OfThickness {
  int trials = 0;
  std::vector<double> errors, solve, whole;
};

Volume thin_ct(const Patient& patient) {
  sim::CtOptions scan;
  scan.seed = patient.seed;
  scan.spacing_mm = {1.5, 1.5, 1.0};
  auto ct = sim::scan_ct(patient.phantom, scan);
  NAV_CHECK(ct.has_value(), patient.seed);
  return std::move(*ct);
}

void add(const Patient& patient, const RecordedSweep& recorded, const Volume& ct,
         const registration::ImageRegistrationOptions& options, OfThickness& out) {
  ++out.trials;
  const auto prepared = PreparedCt::create(ct, options);
  NAV_CHECK(prepared.has_value(), patient.seed);
  CollectingDiagnostics diagnostics;
  const double before = thread_time_s();
  const auto sweep = PreparedSweep::create(recorded.sweep, options, diagnostics);
  NAV_CHECK(sweep.has_value(), patient.seed);
  const double ready = thread_time_s();
  const CtPose start = start_at(kSliceStartMm, patient.truth, recorded, patient.seed);
  const auto result = register_prepared(*prepared, *sweep, start, options);
  const double after = thread_time_s();
  out.solve.push_back(after - ready);
  out.whole.push_back(after - before);
  if (!result) return;
  const double error_mm =
      target_error_mm(result->ct_from_reference, patient.truth, recorded.targets);
  if (error_mm < kSuccessMm) out.errors.push_back(error_mm);
}

}  // namespace

Volume with_thick_slices(const Volume& ct, int slices) {
  VoxelGrid grid = ct.grid();
  NAV_CHECK(slices >= 1 && slices <= grid.size[2], slices, grid.size[2]);
  grid.origin_mm = grid.at({0, 0, 0.5 * (slices - 1)}).mm;
  grid.spacing_mm.z() *= slices;
  grid.size[2] /= slices;
  const std::size_t area = as_size(grid.size[0]) * as_size(grid.size[1]);
  std::vector<std::int16_t> hu(grid.voxel_count());
  for (std::size_t i = 0; i < hu.size(); ++i) {
    const std::size_t first = i / area * as_size(slices) * area + i % area;
    double sum = 0;
    for (std::size_t k = 0; k < as_size(slices); ++k) sum += ct.hu()[first + k * area];
    hu[i] = static_cast<std::int16_t>(std::lround(sum / slices));
  }
  auto thick = Volume::create(grid, std::move(hu), ct.name());
  NAV_CHECK(thick.has_value(), slices);
  return std::move(*thick);
}

std::vector<EffortPoint> measure_slices(const SliceOptions& options, CaseStore& store,
                                        const std::function<void(double)>& progress) {
  constexpr std::array kPaths{SweepPath::kSubcostal, SweepPath::kFan, SweepPath::kSlide,
                              SweepPath::kSagittal, SweepPath::kCross};
  std::vector<OfThickness> found(options.thickness_mm.size());
  for (int i = 0; i < options.patients; ++i) {
    const std::uint64_t seed = options.first_seed + static_cast<std::uint64_t>(i);
    const auto patient = store.patient(seed);
    const auto recorded =
        store.sweep(seed, kPaths[as_size(i) % kPaths.size()], default_cohort().frames);
    if (!options.keep) store.forget(seed);
    const Volume thin = thin_ct(*patient);
    for (std::size_t k = 0; k < found.size(); ++k) {
      add(*patient, *recorded, with_thick_slices(thin, options.thickness_mm[k]), options.local,
          found[k]);
    }
    if (progress) progress((i + 1.0) / options.patients);
  }
  std::vector<EffortPoint> points;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const OfThickness& of = found[k];
    points.push_back({.axis = "slices",
                      .x = static_cast<double>(options.thickness_mm[k]),
                      .trials = of.trials,
                      .right = static_cast<int>(of.errors.size()),
                      .error_median_mm = median(of.errors),
                      .error_p95_mm = quantile(of.errors, 0.95),
                      .solve_cpu_s = median(of.solve),
                      .cpu_s = median(of.whole)});
  }
  return points;
}

}  // namespace nav::bench
