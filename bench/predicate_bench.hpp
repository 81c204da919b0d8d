// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "bench/predicate_bench_gl.hpp"
#include "bench/predicate_edit.hpp"
#include "nav/diagnostics.hpp"
#include "nav/result.hpp"

namespace nav::bench {

struct PredicateBenchOptions {
  int side = 256;  ///< Of the phantom, voxels, [32, 768].
  int width = 800;
  int height = 600;
  int threads = 0;  ///< 0: all cores.
  Repeats repeats{5, 4};
  std::string volume;    ///< Only volumes whose name begins so; empty: all.
  std::string look;      ///< Only set-ups whose name begins so; empty: all.
  bool cpu = true;       ///< The CPU engine.
  bool gl = true;        ///< The GL engine, where there is OpenGL.
  bool patients = true;  ///< Also on simulated patients (sim/predicate_patient.hpp).
};

/// One scene on the CPU engine: predicates beside the standard transfer function of the same
/// volume, step and opacities, beside brute force (no brick, every predicate at every sample, no
/// early end), and how much ending rays early changes the picture.
struct PredicateBenchRow {
  std::string scene;
  double standard_cpu_ms = 0;
  double predicate_cpu_ms = 0;
  double brute_cpu_ms = 0;
  double standard_wall_ms = 0;  ///< As long as it took, with whatever else ran beside it.
  double predicate_wall_ms = 0;
  std::uint64_t standard_samples = 0;
  std::uint64_t predicate_samples = 0;
  std::uint64_t brute_samples = 0;
  double max_error = 0;    ///< Of early termination, of any channel, [0, 1].
  bool identical = false;  ///< Skipping on and off draw the same bytes.
  double prepare_ms = 0;   ///< Wall time after a new importance: process time of the whole edit.
  /// The same after another set of predicates: from one that reads nothing but the volume, features
  /// being there.
  double set_edit_ms = 0;
  ProgressiveEdit edit;     ///< From that set too.
  double engine_bytes = 0;  ///< RAM of one engine that has drawn it, volume and features excluded.
};

struct PredicateBenchReport {
  std::vector<PredicateBenchRow> rows;
  int rays_checked = 0;      ///< Random rays of the early-termination theorem.
  int bound_violations = 0;  ///< Of them.
  double naive_error = 0;    ///< Worst error of stopping by opacity alone, in a pixel of them.
  std::optional<GlPredicateReport> gl;  ///< Absent: no OpenGL.
  /// PredicateBenchRow::engine_bytes, greatest over scenes; MB. Absent: no CPU engine.
  std::optional<double> megabytes;

  /// Median over scenes of standard_cpu_ms / predicate_cpu_ms.
  [[nodiscard]] double predicate_over_standard() const;
  /// Median over scenes of brute_cpu_ms / predicate_cpu_ms.
  [[nodiscard]] double brute_over_predicate() const;
  /// The greatest over scenes; NaN, as both medians: the CPU engine was not measured.
  [[nodiscard]] double max_error() const;
  [[nodiscard]] double worst_set_edit_wall_ms() const;
};

/// Reports data that is missing as skipped; progress with the share done.
Result<PredicateBenchReport> measure_predicates(const PredicateBenchOptions& options,
                                                Diagnostics& diagnostics,
                                                const std::function<void(double)>& progress = {});

/// Plain-text table.
std::string to_text(const PredicateBenchReport& report);

}  // namespace nav::bench
