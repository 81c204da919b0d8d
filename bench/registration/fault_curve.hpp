// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/registration/fault_case.hpp"
#include "bench/registration/trials.hpp"

namespace nav::bench {

/// What one registration of a sweep with a fault came to.
struct FaultTrial {
  Fault fault;
  bool solved = false;    ///< False: refused before a pose was found.
  bool accepted = false;  ///< With warnings or without.
  bool warned = false;
  double error_mm = 0;      ///< At the targets, RMS; meaningless unless solved.
  double predicted_mm = 0;  ///< The same as predicted; infinite where nothing is predicted.
  std::optional<registration::MisfitCause> named;  ///< By the decision.
  /// Of find_misfits() alone; absent where it had nothing to go by.
  std::optional<double> misfits_cpu_s;

  [[nodiscard]] bool false_accept() const { return accepted && !(error_mm <= kFalseAcceptMm); }
};

/// All registrations with one fault of one size.
struct FaultPoint {
  Fault fault;
  int runs = 0;
  int solved = 0;
  int clear = 0;             ///< Accepted without warnings,
  int warned = 0;            ///< with warnings,
  int refused = 0;           ///< and refused, the unsolved included: together all runs.
  int false_accepts = 0;     ///< Accepted, with warnings or without, at an error above 3 mm.
  int named = 0;             ///< A cause was named,
  int named_right = 0;       ///< and it is the true one.
  double error_mean_mm = 0;  ///< Of the accepted; this and what follows: NaN without.
  double error_max_mm = 0;
  double actual_over_predicted = 0;  ///< Median of the accepted.
  double misfits_cpu_ms = 0;         ///< Median of those that it was measured of.
};

/// By fault and size, in the order in which they first come.
std::vector<FaultPoint> count_faults(const std::vector<FaultTrial>& trials);

struct FaultCurveOptions {
  SweepChoice sweeps{.hands = {sim::HandPathKind::kSweep, sim::HandPathKind::kTilt}};
  std::vector<Fault> faults = default_faults();
};

/// Every fault that is not in the patient on every sweep of the cohort, those in the patient on a
/// simulated session of every hand, none on both; registered with the settings of the cohort,
/// seeded starts included, and judged as a user would be told. One thread. Errors: those of the
/// simulator.
Result<std::vector<FaultTrial>> run_faults(const FaultCurveOptions& options, CaseStore& store,
                                           const std::function<void(double)>& progress = {});

std::string to_text(const std::vector<FaultPoint>& points, const std::string& title);

}  // namespace nav::bench
