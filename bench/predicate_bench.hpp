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
  int side = 256;  ///< Side of the phantom, voxels, [32, 768].
  int width = 800;
  int height = 600;
  int threads = 0;  ///< 0: all cores.
  Repeats repeats{5, 4};
  std::string volume;      ///< Only volumes whose name begins with this; empty: all.
  std::string appearance;  ///< Only predicate sets whose name begins with this; empty: all.
  bool cpu = true;         ///< The CPU engine.
  bool gl = true;          ///< The GL engine, if there is OpenGL.
  bool patients = true;    ///< Also on simulated patients (sim/predicate_patient.hpp).
};

/// One scene on the CPU engine. Predicates are compared with the standard transfer function of the
/// same volume, step and opacities, and with brute force (no bricks, every predicate at every
/// sample, no early termination). It also tells how much early termination changes the image.
struct PredicateBenchRow {
  std::string scene;
  double standard_cpu_ms = 0;
  double predicate_cpu_ms = 0;
  double brute_cpu_ms = 0;
  double standard_wall_ms = 0;  ///< Elapsed time, including other load on the machine.
  double predicate_wall_ms = 0;
  std::uint64_t standard_samples = 0;
  std::uint64_t predicate_samples = 0;
  std::uint64_t brute_samples = 0;
  double max_error = 0;    ///< Error of early termination in any channel, [0, 1].
  bool identical = false;  ///< Skipping on and off draw the same bytes.
  double prepare_ms = 0;   ///< Wall time after a new importance; process time of the whole edit.
  /// Wall time after a change of the predicate set: from a set that reads only the volume, with
  /// features already present.
  double set_edit_ms = 0;
  ProgressiveEdit edit;  ///< After the same change of the predicate set.
  ProgressiveEdit bar;   ///< After the first bar of the histogram was dragged.
  /// RAM of one engine that has drawn the scene, without volume and features.
  double engine_bytes = 0;
};

struct PredicateBenchReport {
  std::vector<PredicateBenchRow> rows;
  int rays_checked = 0;      ///< Random rays of the early-termination theorem.
  int bound_violations = 0;  ///< Rays that violate the bound.
  double naive_error = 0;    ///< Worst error of stopping by opacity alone, in one of their pixels.
  std::optional<GlPredicateReport> gl;  ///< Absent: no OpenGL.
  /// Largest PredicateBenchRow::engine_bytes over the scenes; MB. Absent: no CPU engine.
  std::optional<double> megabytes;

  /// Median over scenes of standard_cpu_ms / predicate_cpu_ms.
  [[nodiscard]] double predicate_over_standard() const;
  /// Median over scenes of brute_cpu_ms / predicate_cpu_ms.
  [[nodiscard]] double brute_over_predicate() const;
  /// The largest over scenes; NaN, like both medians, if the CPU engine was not measured.
  [[nodiscard]] double max_error() const;
  [[nodiscard]] double worst_set_edit_wall_ms() const;
  /// The largest over scenes of the time until an image is whole, after either edit.
  [[nodiscard]] double worst_whole_ms() const;
};

/// Reports missing data as skipped; progress receives the fraction done.
Result<PredicateBenchReport> measure_predicates(const PredicateBenchOptions& options,
                                                Diagnostics& diagnostics,
                                                const std::function<void(double)>& progress = {});

/// Plain-text table.
std::string to_text(const PredicateBenchReport& report);

}  // namespace nav::bench
