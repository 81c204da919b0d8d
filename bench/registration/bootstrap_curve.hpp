// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/registration/case_store.hpp"
#include "registration/uncertainty/frame_bootstrap.hpp"

namespace nav::bench {

/// Run time against error of the number of replicates.
struct BootstrapPoint {
  int replicates;
  double cpu_us;  ///< Median of the sweeps.
  /// By how much the predicted target error differs from that of kBootstrapMost replicates of
  /// other draws, share of it, RMS over sweeps and seeds.
  double off;
};
inline constexpr int kBootstrapMost = 20000;

/// The one step of every replicate beside a full solve of the same pictures drawn.
struct BootstrapReference {
  std::uint64_t patient;
  SweepPath path;
  int pictures, block;
  double error_mm;     ///< Of the registration, against the truth; all are RMS over the targets.
  double clusters_mm;  ///< Predicted by clusters of patches, without a floor.
  double step_mm;      ///< Predicted by the steps, without a floor.
  double solved_mm;    ///< By the solves.
  double apart;        ///< Between step and solve of the same draw, RMS over draws, of solved_mm.
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
  int solved = 100;  ///< Replicates that are solved in full.
  std::vector<int> replicates{25, 50, 100, 200, 400, 800, 1600};
};

/// One thread.
BootstrapCurve measure_bootstrap(const BootstrapCurveOptions& options, CaseStore& store,
                                 const std::function<void(double)>& progress = {});

std::string to_text(const BootstrapCurve& curve);

}  // namespace nav::bench
