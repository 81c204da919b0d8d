// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/registration/trials.hpp"

namespace nav::bench {

/// A point of run time against error: local registration from 5 mm, one knob changed.
struct EffortPoint {
  std::string axis;  ///< "patches" (share of the default), "pictures", "levels" (finest left out).
  double x;
  int trials, right;
  double error_median_mm, error_p95_mm;  ///< Of the right ones; NaN without.
  double solve_cpu_s, cpu_s;  ///< Medians: with everything prepared; with the sweep's preparation.
};

struct EffortOptions {
  std::uint64_t first_seed = 1;
  int patients = 2;
  std::vector<double> patch_shares{0.25, 0.5, 1, 2, 4};
  std::vector<int> pictures{10, 20, 30, 60, 120};
  registration::ImageRegistrationOptions local;
};

std::vector<EffortPoint> measure_effort(const EffortOptions& options,
                                        const std::function<void(double)>& progress = {});

std::string to_text(const std::vector<EffortPoint>& points);

}  // namespace nav::bench
