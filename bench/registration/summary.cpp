// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/summary.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <map>
#include <sstream>

#include "bench/measure.hpp"

namespace nav::bench {
namespace {

constexpr double kGlobalMm = 40;
constexpr double kLocalMm = 10;

double share(int part, int whole) {
  return whole > 0 ? static_cast<double>(part) / whole : std::numeric_limits<double>::quiet_NaN();
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double one : values) sum += one;
  return values.empty() ? std::numeric_limits<double>::quiet_NaN()
                        : sum / static_cast<double>(values.size());
}

/// Values of one sweep, which are correlated.
struct SweepSum {
  double sum = 0;
  int count = 0;
};
using SweepSums = std::map<std::pair<std::uint64_t, SweepPath>, SweepSum>;

/// Standard error of the mean of all values.
double standard_error(const SweepSums& sums, double mean) {
  double squares = 0;
  int values = 0;
  for (const auto& [sweep, of] : sums) {
    squares += std::pow(of.sum - of.count * mean, 2);
    values += of.count;
  }
  const auto n = static_cast<double>(sums.size());
  return n < 2 ? std::numeric_limits<double>::quiet_NaN()
               : std::sqrt(squares * n / (n - 1)) / values;
}

/// True for starts that should succeed.
bool in_reach(const Trial& trial) {
  return !trial.hopeless && trial.start_mm <= (trial.global ? kGlobalMm : kLocalMm);
}

void add_right(const std::vector<Trial>& trials, CohortSummary& out) {
  std::vector<double> errors, covered, clusters, bootstrap, ratios;
  SweepSums covered_of;
  for (const Trial& trial : trials) {
    if (!in_reach(trial) || !trial.right()) continue;
    ++out.right;
    errors.push_back(trial.error_mm);
    covered.push_back(trial.covered);
    SweepSum& of = covered_of[{trial.patient, trial.path}];
    of.sum += trial.covered;
    ++of.count;
    clusters.push_back(trial.covered_clusters);
    bootstrap.push_back(trial.covered_bootstrap);
    ratios.push_back(trial.predicted_mm / trial.error_mm);
    out.false_refusals += trial.accepted ? 0 : 1;
  }
  out.tre_median_mm = median(errors);
  out.tre_p95_mm = quantile(errors, 0.95);
  out.coverage_95 = mean(covered);
  out.coverage_95_se = standard_error(covered_of, out.coverage_95);
  out.coverage_95_clusters = mean(clusters);
  out.coverage_95_bootstrap = mean(bootstrap);
  out.predicted_over_actual = median(ratios);
}

/// Benefit of warnings: the error of accepted results with and without them.
void add_warned(const std::vector<Trial>& trials, CohortSummary& out) {
  std::vector<double> clear, warned;
  for (const Trial& trial : trials) {
    if (in_reach(trial) && trial.accepted) {
      (trial.warned ? warned : clear).push_back(trial.error_mm);
    }
  }
  out.accepted = static_cast<int>(clear.size() + warned.size());
  out.warned = static_cast<int>(warned.size());
  out.clear_median_mm = median(clear);
  out.clear_p95_mm = quantile(clear, 0.95);
  out.warned_median_mm = median(warned);
  out.warned_p95_mm = quantile(warned, 0.95);
}

void add_success(const std::vector<Trial>& trials, CohortSummary& out) {
  int count[2] = {0, 0};
  int right[2] = {0, 0};
  for (const Trial& trial : trials) {
    if (!in_reach(trial)) continue;
    ++count[trial.global ? 1 : 0];
    right[trial.global ? 1 : 0] += trial.right() ? 1 : 0;
  }
  out.success_local_10mm = share(right[0], count[0]);
  out.success_from_40mm = share(right[1], count[1]);
  out.success_local_10mm_95 = wilson_95(right[0], count[0]);
  out.success_from_40mm_95 = wilson_95(right[1], count[1]);
}

void add_times(const CohortResult& result, CohortSummary& out) {
  std::vector<double> whole[2], solve[2];
  for (const Trial& trial : result.trials) {
    if (!in_reach(trial)) continue;
    const int mode = trial.global ? 1 : 0;
    solve[mode].push_back(trial.solve_cpu_s);
    whole[mode].push_back(trial.solve_cpu_s + trial.sweep_cpu_s);
  }
  out.local_cpu_s = median(whole[0]);
  out.global_cpu_s = median(whole[1]);
  out.local_solve_cpu_s = median(solve[0]);
  out.global_solve_cpu_s = median(solve[1]);
  out.ct_cpu_s = median(result.ct_cpu_s);
}

void add_rows(const std::vector<Trial>& trials, CohortSummary& out) {
  std::map<std::pair<bool, double>, std::vector<const Trial*>> distances;
  std::map<Hopeless, HopelessRow> hopeless;
  int refused = 0;
  int count = 0;
  for (const Trial& trial : trials) {
    if (!trial.hopeless) {
      distances[{trial.global, trial.start_mm}].push_back(&trial);
      continue;
    }
    HopelessRow& row =
        hopeless.try_emplace(*trial.hopeless, HopelessRow{*trial.hopeless, 0, 0, 0}).first->second;
    ++row.trials;
    row.refused += trial.accepted ? 0 : 1;
    row.false_accepts += trial.false_accept() ? 1 : 0;
    ++count;
    refused += !trial.accepted || trial.right() ? 1 : 0;
  }
  out.hopeless_refused = share(refused, count);
  for (const auto& [key, of] : distances) {
    DistanceRow row{.global = key.first, .start_mm = key.second};
    std::vector<double> errors;
    for (const Trial* trial : of) {
      ++row.trials;
      row.right += trial->right() ? 1 : 0;
      row.accepted += trial->accepted ? 1 : 0;
      row.false_accepts += trial->false_accept() ? 1 : 0;
      if (trial->right()) errors.push_back(trial->error_mm);
    }
    row.error_median_mm = median(errors);
    out.distances.push_back(row);
  }
  for (const auto& [kind, row] : hopeless) out.hopeless.push_back(row);
}

/// Probability of at most k of n when each has probability p.
double binomial_cdf(int k, int n, double p) {
  double sum = 0;
  for (int i = 0; i <= k; ++i) {
    const double log_term = std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) +
                            i * std::log(p) + (n - i) * std::log1p(-p);
    sum += std::exp(log_term);
  }
  return sum;
}

}  // namespace

Interval wilson_95(int k, int n) {
  if (n < 1) return {};
  constexpr double kZ = 1.959964;
  const double p = static_cast<double>(k) / n;
  const double zz = kZ * kZ / n;
  const double middle = (p + 0.5 * zz) / (1 + zz);
  const double half = kZ * std::sqrt((p * (1 - p) + 0.25 * zz) / n) / (1 + zz);
  return {std::max(middle - half, 0.0), std::min(middle + half, 1.0)};
}

double share_bound_95(int k, int n) {
  if (n < 1 || k >= n) return 1;
  double low = 0;
  double high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (binomial_cdf(k, n, middle) > 0.05 ? low : high) = middle;
  }
  return high;
}

CohortSummary summarise(const CohortResult& result) {
  CohortSummary out;
  out.trials = static_cast<int>(result.trials.size());
  for (const Trial& trial : result.trials) out.false_accepts += trial.false_accept() ? 1 : 0;
  out.false_accept_bound = share_bound_95(out.false_accepts, out.trials);
  add_right(result.trials, out);
  add_warned(result.trials, out);
  add_success(result.trials, out);
  add_times(result, out);
  add_rows(result.trials, out);
  return out;
}

namespace {
std::ostream& operator<<(std::ostream& out, const Interval& interval) {
  return out << '[' << interval.low << ", " << interval.high << ']';
}
}  // namespace

std::string to_text(const CohortSummary& s, const std::string& title) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(3) << '\n'
       << title << ": " << s.trials << " registrations\n"
       << "target error median " << s.tre_median_mm << " mm, p95 " << s.tre_p95_mm << " mm\n"
       << "success: local to 10 mm " << s.success_local_10mm << ' ' << s.success_local_10mm_95
       << ", global to 40 mm " << s.success_from_40mm << ' ' << s.success_from_40mm_95 << '\n'
       << "false accepts " << s.false_accepts << " (share below " << s.false_accept_bound
       << "), correct but refused " << s.false_refusals << " of " << s.right
       << ", hopeless refused " << s.hopeless_refused << '\n'
       << "accepted " << s.accepted << ", with warnings " << s.warned << ": error median, p95 "
       << s.clear_median_mm << ", " << s.clear_p95_mm << " mm without, " << s.warned_median_mm
       << ", " << s.warned_p95_mm << " mm with\n"
       << "95 % intervals cover " << s.coverage_95 << " +- " << s.coverage_95_se
       << " (clusters alone " << s.coverage_95_clusters << ", replicates alone, without a floor, "
       << s.coverage_95_bootstrap << "), predicted over actual error, median "
       << s.predicted_over_actual << '\n'
       << "processor s: local " << s.local_cpu_s << " (solve " << s.local_solve_cpu_s
       << "), global " << s.global_cpu_s << " (solve " << s.global_solve_cpu_s << "), CT once "
       << s.ct_cpu_s << '\n';
  for (const DistanceRow& row : s.distances) {
    text << "  " << (row.global ? "global" : "local ") << " from " << std::setw(3)
         << static_cast<int>(row.start_mm) << " mm: correct " << row.right << '/' << row.trials
         << ", accepted " << row.accepted << " (falsely " << row.false_accepts << "), median "
         << row.error_median_mm << " mm\n";
  }
  for (const HopelessRow& row : s.hopeless) {
    text << "  " << std::setw(13) << std::left << to_string(row.kind) << std::right << ": refused "
         << row.refused << '/' << row.trials << ", false accepts " << row.false_accepts << '\n';
  }
  return text.str();
}

}  // namespace nav::bench
