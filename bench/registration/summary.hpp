// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bench/registration/trials.hpp"

namespace nav::bench {

/// Starts of one distance.
struct DistanceRow {
  bool global;
  double start_mm;
  int trials, right, accepted, false_accepts;
  double error_median_mm;  ///< Of the right ones; NaN without.
};

/// One kind of hopeless input.
struct HopelessRow {
  Hopeless kind;
  int trials, refused, false_accepts;
};

/// [low, high].
struct Interval {
  double low = 0, high = 1;
};

/// The headline figures of one cohort. Shares are of [0, 1]; NaN where there was no trial.
struct CohortSummary {
  int trials = 0;
  double tre_median_mm = 0;      ///< Target error of the right results, starts up to 40 mm.
  double tre_p95_mm = 0;         ///< The same, 95th percentile.
  double success_from_40mm = 0;  ///< Global, starts of 5 to 40 mm, target error below 2 mm.
  double success_local_10mm = 0;
  Interval success_from_40mm_95, success_local_10mm_95;  ///< Wilson (1927).
  int false_accepts = 0;          ///< Accepted with a target error above 3 mm, hopeless included.
  double false_accept_bound = 0;  ///< One-sided 95 % Clopper–Pearson bound of their share.
  int false_refusals = 0;         ///< Right and refused, starts up to 40 mm.
  int right = 0;                  ///< What false_refusals is counted of.
  int accepted = 0;               ///< Starts up to 40 mm, right or not.
  int warned = 0;                 ///< Of these, accepted with warnings.
  double clear_median_mm = 0, clear_p95_mm = 0;    ///< Target error of the accepted without.
  double warned_median_mm = 0, warned_p95_mm = 0;  ///< And with warnings; NaN without any.
  double hopeless_refused = 0;  ///< Share refused; those that came out right count as refused.
  double coverage_95 = 0;       ///< Mean share of targets in their ellipsoid, right results.
  double coverage_95_se = 0;    ///< Its standard error, from sweep to sweep; NaN of fewer than two.
  /// The same of what the uncertainty is the larger of; the replicates without a floor.
  double coverage_95_clusters = 0, coverage_95_bootstrap = 0;
  double predicted_over_actual = 0;  ///< Median of predicted over actual target error, RMS.
  double local_cpu_s = 0;            ///< Median: sweep preparation, solve, checks; CT prepared.
  double global_cpu_s = 0;
  double local_solve_cpu_s = 0;  ///< The same without the preparation of the sweep.
  double global_solve_cpu_s = 0;
  double ct_cpu_s = 0;  ///< Preparation of a CT, once.
  std::vector<DistanceRow> distances;
  std::vector<HopelessRow> hopeless;
};

CohortSummary summarise(const CohortResult& result);

/// Upper end of the one-sided 95 % Clopper–Pearson interval of a share: k of n seen.
double share_bound_95(int k, int n);

/// 95 % interval of a share, k of n seen (Wilson 1927); [0, 1] for n = 0.
Interval wilson_95(int k, int n);

/// Value below which a share q of the values lies (nearest rank); NaN for no values.
double quantile(std::vector<double> values, double q);

std::string to_text(const CohortSummary& summary, const std::string& title);

}  // namespace nav::bench
