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

/// Result of one registration of a sweep with a fault.
struct FaultTrial {
  Fault fault;
  bool solved = false;    ///< False: rejected before a pose was found.
  bool accepted = false;  ///< With or without warnings.
  bool warned = false;
  double error_mm = 0;      ///< At the targets, RMS; meaningless unless solved.
  double predicted_mm = 0;  ///< Predicted value of error_mm; infinite if nothing is predicted.
  std::optional<registration::MisfitCause> named;  ///< Cause that the decision names.
  /// Processor time of find_misfits() alone; absent if it had no data.
  std::optional<double> misfits_cpu_s;

  [[nodiscard]] bool false_accept() const { return accepted && !(error_mm <= kFalseAcceptMm); }
};

/// Counts of all registrations with one fault of one size.
struct FaultPoint {
  Fault fault;
  int runs = 0;
  int solved = 0;
  int clear = 0;    ///< Accepted without warnings.
  int warned = 0;   ///< Accepted with warnings.
  int refused = 0;  ///< Rejected, including unsolved: with clear and warned they add up to runs.
  int false_accepts = 0;  ///< Accepted, with or without warnings, at an error above 3 mm.
  int named = 0;          ///< A cause was named.
  int named_right = 0;    ///< The named cause is the true one.
  /// Mean over the accepted; this and the following values are NaN if there are none.
  double error_mean_mm = 0;
  double error_max_mm = 0;
  double actual_over_predicted = 0;  ///< Median over the accepted.
  double misfits_cpu_ms = 0;         ///< Median over the trials with a measurement.
};

/// One point for each fault and size, in the order of their first trials.
std::vector<FaultPoint> count_faults(const std::vector<FaultTrial>& trials);

struct FaultCurveOptions {
  SweepChoice sweeps{.hands = {sim::HandPathKind::kSweep, sim::HandPathKind::kTilt}};
  std::vector<Fault> faults = default_faults();
};

/// Runs the faults that are not of the patient on every sweep of the cohort, those of the patient
/// on a simulated session of every hand motion, and kNone on both. Registers with the settings of
/// the cohort, seeded starts included, and judges the results as for a user. One thread. Errors:
/// those of the simulator.
Result<std::vector<FaultTrial>> run_faults(const FaultCurveOptions& options, CaseStore& store,
                                           const std::function<void(double)>& progress = {});

std::string to_text(const std::vector<FaultPoint>& points, const std::string& title);

}  // namespace nav::bench
