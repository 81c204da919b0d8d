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

/// Whether what is said of a pose depends on where the search for it began.
namespace nav::bench {

/// What one of a sweep's registrations came to.
struct StartTrial {
  CtPose pose;
  double cost = 1;
  bool accepted = false;
  double predicted_mm = 0;  ///< At the targets, RMS; infinite where nothing is predicted.
  /// A calibration that is so far off, in the direction that the sweep shows least of, would be
  /// only just worth a warning, mm; infinite where the sweep never shows it. Absent where nothing
  /// could be found.
  std::optional<double> hidden_mm;
};

/// The registrations of one sweep to one CT from all starts.
struct StartSweep {
  std::string path;                ///< Of the cohort's sweep, or of a simulated session's hand.
  bool own_ct = true;              ///< False: that of another patient.
  std::vector<StartTrial> trials;  ///< Of those that found a pose.
  std::vector<Point<frames::Reference>> targets{};  ///< Not empty where trials are not.
};

/// Results whose targets are so near to those of the cheapest one, RMS, are one pose.
inline constexpr double kSamePoseMm = 0.5;

/// The sweeps of one path and kind of CT; of each the results at the pose that costs least.
struct StartPoint {
  std::string path;
  bool own_ct;
  int sweeps = 0;
  int registrations = 0;  ///< That found a pose,
  int same = 0;           ///< and that of the cheapest one of the sweep.
  int accepted = 0;       ///< Of these.
  int elsewhere = 0;      ///< Of the others, accepted too.
  int split = 0;          ///< Sweeps where that pose was accepted from some starts only.
  /// Of a sweep the largest distance from its cheapest result at the targets, RMS: median and
  /// maximum over sweeps, mm.
  double apart_mm = 0, apart_max_mm = 0;
  /// Of a sweep the largest predicted error over the smallest: median and maximum over sweeps,
  /// infinite where nothing is predicted from some starts.
  double predicted_ratio = 1, predicted_ratio_max = 1;
  /// StartTrial::hidden_mm of the cheapest results, least and most of the sweeps; NaN without any.
  double hidden_least_mm = 0, hidden_most_mm = 0;
};

/// By path and CT, in the order in which they first come. Sweeps without a pose count as sweeps
/// alone.
std::vector<StartPoint> count_starts(const std::vector<StartSweep>& sweeps);

struct StartCurveOptions {
  SweepChoice sweeps{
      .hands = {sim::HandPathKind::kFan, sim::HandPathKind::kRock, sim::HandPathKind::kTilt}};
  std::vector<double> starts_mm{3, 4, 5, 6, 7, 8, 9, 10};  ///< Target error of each start.
};

/// Every sweep of the cohort in its own CT and in that of the patient of the next seed, simulated
/// sessions of every hand in their own, registered from every start with the settings of the
/// cohort, seeded starts included, and judged as a user would be told. One thread. Errors: those of
/// the simulator.
Result<std::vector<StartSweep>> run_starts(const StartCurveOptions& options, CaseStore& store,
                                           const std::function<void(double)>& progress = {});

std::string to_text(const std::vector<StartPoint>& points);

}  // namespace nav::bench
