// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/registration/case_store.hpp"
#include "registration/uncertainty/image_bootstrap.hpp"

namespace nav::bench {

/// Run time against error for one number of replicates.
struct BootstrapPoint {
  int replicates;
  double cpu_us;  ///< Median over the sweeps.
  /// Difference of the predicted target error from that of kBootstrapMost replicates of other
  /// draws, as a fraction of it, RMS over sweeps and seeds.
  double off;
};
inline constexpr int kBootstrapMost = 20000;

/// Comparison of the single step of every replicate with a full solve of the same drawn images.
struct BootstrapReference {
  std::uint64_t patient;
  SweepPath path;
  int images, block;
  /// Error of the registration against the truth; all errors are RMS over the targets.
  double error_mm;
  double clusters_mm;  ///< Error predicted by clusters of patches, without a floor.
  double step_mm;      ///< Error predicted by the steps, without a floor.
  double solved_mm;    ///< Error predicted by the full solves.
  /// Distance between step and solve of the same draw, RMS over draws, as a fraction of solved_mm.
  double apart;
  double solved_cpu_s;
};

struct BootstrapCurve {
  std::vector<BootstrapPoint> points;
  std::vector<BootstrapReference> references;
};

struct BootstrapCurveOptions {
  std::uint64_t first_seed = 1;
  int patients = 4;
  std::vector<SweepPath> paths{SweepPath::kSubcostal, SweepPath::kFan, SweepPath::kSlide};
  int solved = 100;  ///< Replicates that are solved fully.
  std::vector<int> replicates{25, 50, 100, 200, 400, 800, 1600};
};

/// Measures the curve on one thread.
BootstrapCurve measure_bootstrap(const BootstrapCurveOptions& options, CaseStore& store,
                                 const std::function<void(double)>& progress = {});

std::string to_text(const BootstrapCurve& curve);

}  // namespace nav::bench
