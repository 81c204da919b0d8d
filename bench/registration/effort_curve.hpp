// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/registration/trials.hpp"

namespace nav::bench {

/// The same with a share of the patches of every level, but no fewer than 50.
registration::ImageRegistrationOptions with_patch_share(
    registration::ImageRegistrationOptions options, double share);

/// A point of run time against error: local registration from 5 mm, one knob changed.
struct EffortPoint {
  /// "patches" (share of the default), "pictures" (evenly chosen of the sweep's), "levels" (of the
  /// pyramid, finest left out), "iterations" (of each solve, at most), "precision" (mm between
  /// samples of the finest level), "quick" (share of the patches of a quick registration), "slices"
  /// (thickness of the CT's, mm).
  std::string axis;
  double x;
  int trials, right;
  double error_median_mm, error_p95_mm;  ///< Of the right ones; NaN without.
  double solve_cpu_s, cpu_s;  ///< Medians: with everything prepared; with the sweep's preparation.
};

struct EffortOptions {
  std::uint64_t first_seed = 1;
  int patients = 4;
  std::vector<SweepPath> paths{SweepPath::kSubcostal, SweepPath::kCross};
  std::vector<double> patch_shares{0.25, 0.5, 1, 2, 4};
  std::vector<int> picture_strides{6, 4, 2, 1};
  std::vector<int> iterations{1, 2, 3, 5, 30};
  std::vector<double> sample_steps_mm{0.8, 1.2, 1.6, 2.4};
  std::vector<double> quick_shares{0.5, 1, 2, 4};
  int threads = 1;
  registration::ImageRegistrationOptions local;
};

/// On sweeps of the store, which keeps them.
std::vector<EffortPoint> measure_effort(const EffortOptions& options, CaseStore& store,
                                        const std::function<void(double)>& progress = {});

std::string to_text(const std::vector<EffortPoint>& points);

}  // namespace nav::bench
