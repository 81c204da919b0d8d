// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/registration/trials.hpp"

namespace nav::bench {

/// The options with a fraction of the patches of every level, but at least 50.
registration::ImageRegistrationOptions with_patch_share(
    registration::ImageRegistrationOptions options, double share);

/// A point of run time against error: local registration from 5 mm, with one setting changed.
struct EffortPoint {
  /// `patches` (fraction of the default), `pictures` (evenly chosen images of the sweep), `levels`
  /// (levels of the pyramid, the finest left out), `iterations` (largest number in each solve),
  /// `precision` (mm between samples of the finest level), `quick` (fraction of the patches of a
  /// quick registration), `slices` (slice thickness of the CT, mm).
  std::string axis;
  double x;
  int trials = 0, right = 0;
  double error_median_mm = 0, error_p95_mm = 0;  ///< Error of right results; NaN for none.
  /// Medians: with everything prepared; with the preparation of the sweep.
  double solve_cpu_s = 0, cpu_s = 0;
};

struct EffortOptions {
  std::uint64_t first_seed = 1;
  int patients = 4;
  std::vector<SweepPath> paths{SweepPath::kSubcostal, SweepPath::kCross};
  std::vector<double> patch_shares{0.25, 0.5, 1, 2, 4};
  std::vector<int> image_strides{6, 4, 2, 1};
  std::vector<int> iterations{1, 2, 3, 5, 30};
  std::vector<double> sample_steps_mm{0.8, 1.2, 1.6, 2.4};
  std::vector<double> quick_shares{0.5, 1, 2, 4};
  int threads = 1;
  registration::ImageRegistrationOptions local;
};

/// Measures on sweeps of the store, which keeps them.
std::vector<EffortPoint> measure_effort(const EffortOptions& options, CaseStore& store,
                                        const std::function<void(double)>& progress = {});

std::string to_text(const std::vector<EffortPoint>& points);

}  // namespace nav::bench
