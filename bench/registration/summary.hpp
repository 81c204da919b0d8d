// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bench/registration/trials.hpp"
#include "nav/statistics.hpp"

namespace nav::bench {

/// Results of the starts of one distance.
struct DistanceRow {
  bool global;
  double start_mm;
  int trials = 0, right = 0, accepted = 0, false_accepts = 0;
  double error_median_mm = 0;  ///< Error of the right results; NaN if there are none.
};

/// Results of one kind of hopeless input.
struct HopelessRow {
  Hopeless kind;
  int trials, refused, false_accepts;
};

/// [low, high].
struct Interval {
  double low = 0, high = 1;
};

/// Main figures of one cohort. Fractions are in [0, 1]; NaN if there was no trial.
struct CohortSummary {
  int trials = 0;
  double tre_median_mm = 0;      ///< Target error of the right results, starts up to 40 mm.
  double tre_p95_mm = 0;         ///< 95th percentile of the same.
  double success_from_40mm = 0;  ///< Global, starts of 5 to 40 mm, target error below 2 mm.
  double success_local_10mm = 0;
  Interval success_from_40mm_95, success_local_10mm_95;  ///< Wilson (1927).
  int false_accepts = 0;          ///< Accepted with a target error above 3 mm, hopeless included.
  double false_accept_bound = 0;  ///< One-sided 95 % Clopper–Pearson bound of their fraction.
  int false_refusals = 0;         ///< Right but rejected, starts up to 40 mm.
  int right = 0;                  ///< Right results, the total for false_refusals.
  int accepted = 0;               ///< Starts up to 40 mm, right or not.
  int warned = 0;                 ///< Accepted starts with warnings.
  /// Target error of those accepted without warnings.
  double clear_median_mm = 0, clear_p95_mm = 0;
  /// Target error of those accepted with warnings; NaN if there are none.
  double warned_median_mm = 0, warned_p95_mm = 0;
  double hopeless_refused = 0;  ///< Fraction rejected; right results count as rejected.
  double coverage_95 = 0;       ///< Mean fraction of targets in their ellipsoid, right results.
  double coverage_95_se = 0;    ///< Its standard error between sweeps; NaN for fewer than two.
  /// coverage_95 for the two covariances that the uncertainty takes the larger of; the replicates
  /// are without a floor.
  double coverage_95_clusters = 0, coverage_95_bootstrap = 0;
  double predicted_over_actual = 0;  ///< Median of predicted over actual target error, RMS.
  double local_cpu_s = 0;  ///< Median: sweep preparation, solve, checks; the CT is prepared.
  double global_cpu_s = 0;
  double local_solve_cpu_s = 0;  ///< Without the preparation of the sweep.
  double global_solve_cpu_s = 0;
  double ct_cpu_s = 0;  ///< Preparation of a CT, once.
  std::vector<DistanceRow> distances;
  std::vector<HopelessRow> hopeless;
};

CohortSummary summarise(const CohortResult& result);

/// The cohort at one level of errors.
struct LevelSummary {
  ErrorLevel level;
  CohortSummary summary;
};

/// Upper end of the one-sided 95 % Clopper–Pearson interval of a fraction, k of n.
double share_bound_95(int k, int n);

/// 95 % interval of a fraction, k of n (Wilson 1927); [0, 1] for n = 0.
Interval wilson_95(int k, int n);

std::string to_text(const CohortSummary& summary, const std::string& title);

}  // namespace nav::bench
