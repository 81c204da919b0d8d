// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/effort_curve.hpp"

#include <cmath>
#include <iomanip>
#include <sstream>

#include "bench/measure.hpp"
#include "bench/registration/summary.hpp"

namespace nav::bench {
namespace {

/// Measures one setting: local registration from 5 mm.
EffortPoint measure(const std::string& axis, double x, CohortOptions cohort, CaseStore& store) {
  cohort.local_mm = {5};
  cohort.global_mm = {};
  cohort.hopeless = false;
  cohort.keep = true;
  cohort.global = cohort.local;
  const CohortResult result = run_cohort(cohort, store);
  EffortPoint point{.axis = axis, .x = x};
  std::vector<double> errors, solve, whole;
  for (const Trial& trial : result.trials) {
    ++point.trials;
    solve.push_back(trial.solve_cpu_s);
    whole.push_back(trial.solve_cpu_s + trial.sweep_cpu_s);
    if (!trial.right()) continue;
    ++point.right;
    errors.push_back(trial.error_mm);
  }
  point.error_median_mm = median(errors);
  point.error_p95_mm = quantile(errors, 0.95);
  point.solve_cpu_s = median(solve);
  point.cpu_s = median(whole);
  return point;
}

}  // namespace

registration::ImageRegistrationOptions with_patch_share(
    registration::ImageRegistrationOptions options, double share) {
  for (auto& level : options.levels) {
    level.patches = std::max(50, static_cast<int>(std::lround(share * level.patches)));
  }
  return options;
}

std::vector<EffortPoint> measure_effort(const EffortOptions& options, CaseStore& store,
                                        const std::function<void(double)>& progress) {
  CohortOptions base;
  base.first_seed = options.first_seed;
  base.patients = options.patients;
  base.paths = options.paths;
  base.threads = options.threads;
  base.local = options.local;
  const std::size_t levels = base.local.levels.size();
  const auto total = static_cast<double>(
      options.patch_shares.size() + options.image_strides.size() + options.iterations.size() +
      options.sample_steps_mm.size() + options.quick_shares.size() + levels - 1);
  std::vector<EffortPoint> points;
  const auto add = [&](const std::string& axis, double x, const CohortOptions& cohort) {
    points.push_back(measure(axis, x, cohort, store));
    if (progress) progress(static_cast<double>(points.size()) / total);
  };
  for (const double share : options.patch_shares) {
    CohortOptions cohort = base;
    cohort.local = with_patch_share(base.local, share);
    add("patches", share, cohort);
  }
  for (const int stride : options.image_strides) {
    CohortOptions cohort = base;
    cohort.image_stride = stride;
    add("pictures", (cohort.frames + stride - 1) / stride, cohort);
  }
  for (const int iterations : options.iterations) {
    CohortOptions cohort = base;
    cohort.local.max_iterations = iterations;
    add("iterations", iterations, cohort);
  }
  for (const double step_mm : options.sample_steps_mm) {
    CohortOptions cohort = base;
    cohort.local.levels.back().sample_step_mm = step_mm;
    add("precision", step_mm, cohort);
  }
  for (const double share : options.quick_shares) {
    CohortOptions cohort = base;
    cohort.local = with_patch_share(default_cohort(registration::Effort::kQuick).local, share);
    add("quick", share, cohort);
  }
  for (std::size_t kept = 1; kept < levels; ++kept) {
    CohortOptions cohort = base;
    cohort.local.levels.resize(kept);
    add("levels", static_cast<double>(kept), cohort);
  }
  return points;
}

std::string to_text(const std::vector<EffortPoint>& points) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(3)
       << "\nrun time against error, local from 5 mm: processor s of the solve, and with preparing "
          "the sweep\n";
  for (const EffortPoint& p : points) {
    text << "  " << std::setw(9) << std::left << p.axis << std::right << std::setw(8) << p.x
         << ": correct " << p.right << '/' << p.trials << ", median " << p.error_median_mm
         << " mm, p95 " << p.error_p95_mm << " mm, " << p.solve_cpu_s << ", " << p.cpu_s << '\n';
  }
  return text.str();
}

}  // namespace nav::bench
