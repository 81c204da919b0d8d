// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/registration/case_store.hpp"
#include "bench/registration/trials.hpp"
#include "nav/result.hpp"
#include "sim/motion/hand_path.hpp"

/// Tests if the verdict on a pose depends on the start of the search.
namespace nav::bench {

/// Result of one registration of a sweep.
struct StartTrial {
  CtPose pose;
  double cost = 1;
  bool accepted = false;
  double predicted_mm = 0;  ///< At the targets, RMS; infinite if nothing is predicted.
  /// Calibration error, in the direction that the sweep shows least, that is only just worth a
  /// warning, mm; infinite if the sweep never shows it. Absent if nothing could be found.
  std::optional<double> hidden_mm;
};

/// The registrations of one sweep to one CT from all starts.
struct StartSweep {
  std::string path;    ///< Path of the cohort's sweep, or the hand motion of a simulated session.
  bool own_ct = true;  ///< False: the CT of another patient.
  std::vector<StartTrial> trials;                   ///< The registrations that found a pose.
  std::vector<Point<frames::Reference>> targets{};  ///< Not empty if trials is not.
};

/// Results whose targets are this close to those of the cheapest result, RMS, are one pose.
inline constexpr double kSamePoseMm = 0.5;

/// Counts over the sweeps of one path and kind of CT; the pose of a sweep is that of the lowest
/// cost.
struct StartPoint {
  std::string path;
  bool own_ct;
  int sweeps = 0;
  int registrations = 0;  ///< Registrations that found a pose.
  int same = 0;           ///< Registrations that found the cheapest pose of the sweep.
  int accepted = 0;       ///< Accepted registrations among same.
  int elsewhere = 0;      ///< Accepted registrations at other poses.
  int split = 0;          ///< Sweeps whose cheapest pose was accepted from some starts only.
  /// Largest distance in a sweep from its cheapest result at the targets, RMS: median and maximum
  /// over sweeps, mm.
  double apart_mm = 0, apart_max_mm = 0;
  /// Ratio in a sweep of the largest to the smallest predicted error: median and maximum over
  /// sweeps; infinite if nothing is predicted from some starts.
  double predicted_ratio = 1, predicted_ratio_max = 1;
  /// StartTrial::hidden_mm of the cheapest results, smallest and largest over the sweeps; NaN if
  /// there are none.
  double hidden_least_mm = 0, hidden_most_mm = 0;
};

/// Points by path and CT, in the order of their first sweeps. A sweep without a pose is counted in
/// sweeps only.
std::vector<StartPoint> count_starts(const std::vector<StartSweep>& sweeps);

struct StartCurveOptions {
  SweepChoice sweeps{
      .hands = {sim::HandPathKind::kFan, sim::HandPathKind::kRock, sim::HandPathKind::kTilt}};
  std::vector<double> starts_mm{3, 4, 5, 6, 7, 8, 9, 10};  ///< Target error of each start.
};

/// Registers every sweep of the cohort to its own CT and to that of the patient of the next seed,
/// and simulated sessions of every hand motion to their own CT. It does so from every start with
/// the settings of the cohort, seeded starts included, and judges the results as for a user. One
/// thread. Errors: those of the simulator.
Result<std::vector<StartSweep>> run_starts(const StartCurveOptions& options, CaseStore& store,
                                           const std::function<void(double)>& progress = {});

std::string to_text(const std::vector<StartPoint>& points);

}  // namespace nav::bench
