// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/registration/case_store.hpp"
#include "bench/registration/hopeless.hpp"
#include "registration/acceptance.hpp"
#include "sim/motion/hand_path.hpp"

namespace nav::bench {

/// A result is right if its targets are off by less than this, RMS.
inline constexpr double kSuccessMm = 2;
/// An accepted result that is off by more is a false accept.
inline constexpr double kFalseAcceptMm = 3;

/// Result of one registration. Times are those of its thread.
struct Trial {
  std::optional<ErrorLevel> level;  ///< Absent: errors of the cohort.
  std::uint64_t patient = 0;
  SweepPath path = SweepPath::kSubcostal;
  bool global = false;               ///< With seeded starts; false: the plain solve.
  double start_mm = 0;               ///< Target error of the start.
  std::optional<Hopeless> hopeless;  ///< Absent: a start that should succeed.
  bool acceptable = true;            ///< False: no pose of this case is right.
  bool solved = false;               ///< False: rejected before a pose was found.
  bool accepted = false;
  bool warned = false;      ///< Accepted with warnings.
  double error_mm = 0;      ///< At the targets, RMS; meaningless unless solved and acceptable.
  double predicted_mm = 0;  ///< Predicted value of error_mm; infinite if nothing is predicted.
  double covered = 0;       ///< Fraction of the targets inside their 95 % ellipsoid.
  /// `covered` for the two covariances that the uncertainty takes the larger of: clusters of
  /// patches, and resampled images.
  double covered_clusters = 0, covered_bootstrap = 0;
  double solve_cpu_s = 0;  ///< With CT and sweep prepared.
  double sweep_cpu_s = 0;  ///< Preparation of the sweep.
  std::string reason;      ///< Why it was rejected; empty if accepted.
  /// Values that the decision uses (registration/image_registration.hpp).
  double z_score = 0, cost = 1, overlap = 0, split_mm = 0, halves_mm = 0;
  std::optional<double> margin;
  double basin_mm = 0;
  /// Excess of each registration::MisfitCause.
  std::array<double, registration::kMisfitCauses> excess_mm{};
  double delay_ms = 0, delay_deviation_ms = 0;  ///< Estimated with the pose.

  [[nodiscard]] bool right(double limit_mm = kSuccessMm) const {
    return solved && acceptable && error_mm < limit_mm;
  }
  [[nodiscard]] bool false_accept() const { return accepted && !right(kFalseAcceptMm); }
};

/// Trials to run on patients of consecutive seeds.
struct CohortOptions {
  std::uint64_t first_seed = 1;
  int patients = 8;
  std::vector<SweepPath> paths{SweepPath::kSubcostal, SweepPath::kFan, SweepPath::kSlide,
                               SweepPath::kSagittal, SweepPath::kCross};
  int path_stride = 1;  ///< Only every path_stride-th path, different ones for each patient; >= 1.
  std::vector<double> local_mm{5, 10, 15, 20, 30, 40, 60};
  std::vector<double> global_mm{5, 10, 20, 30, 40, 60};
  int starts = 1;              ///< Starts of each distance.
  bool hopeless = true;        ///< Every kind of hopeless input on every sweep, global.
  bool hopeless_local = true;  ///< Hopeless inputs without seeded starts too.
  /// Only every hopeless_stride-th kind, different ones on each sweep; >= 1.
  int hopeless_stride = 1;
  int frames = 60;       ///< Ultrasound images of a sweep, >= 2.
  int image_stride = 1;  ///< Only every image_stride-th image is registered; >= 1.
  int threads = 1;       ///< Sweeps judged in parallel, >= 1; results do not depend on it.
  bool keep = false;     ///< True: patients stay in the store; false: only as long as needed.
  registration::ImageRegistrationOptions local, global;
  registration::AcceptanceLimits limits;
};

/// Sweeps of the cohort and simulated sessions that some parts of the benchmark register.
struct SweepChoice {
  std::uint64_t first_seed = 1;
  int patients = 4;
  /// Acoustic model of the sessions; the sweeps use that of the store.
  sim::AcousticModel model = sim::AcousticModel::kRays;
  std::vector<SweepPath> paths{SweepPath::kSubcostal, SweepPath::kFan, SweepPath::kSlide,
                               SweepPath::kSagittal, SweepPath::kCross};
  std::vector<sim::HandPathKind> hands;  ///< Hand motions of the sessions.
  double duration_s = 8;                 ///< Duration of a session.
  registration::Effort effort = registration::Effort::kUsual;
  bool keep = false;  ///< True: patients stay in the store; false: only those needed at once.
};

/// Settings of the benchmark: those of the library, with one thread each.
CohortOptions default_cohort(registration::Effort effort = registration::Effort::kUsual);

struct CohortResult {
  std::vector<Trial> trials;     ///< Sorted by patient, path and start, in any order of execution.
  std::vector<double> ct_cpu_s;  ///< Preparation of each patient's CT.
};

/// All trials of one sweep.
std::vector<Trial> run_sweep_trials(const CohortOptions& options, CaseStore& store,
                                    std::uint64_t patient_seed, SweepPath path);

/// Runs the cohort sweep by sweep. progress: called with the fraction done by one thread at a time.
/// done: receives the trials of each sweep as soon as it is judged, one sweep at a time, on any
/// thread.
CohortResult run_cohort(const CohortOptions& options, CaseStore& store,
                        const std::function<void(double)>& progress = {},
                        const std::function<void(const std::vector<Trial>&)>& done = {});

/// Every stride-th image of a sweep; stride >= 1.
Sweep every(int stride, const Sweep& sweep);

/// Predicted target error of a result, RMS over the targets, mm; infinite if there is none.
double predicted_error_mm(const registration::ImageRegistrationResult& result,
                          const std::vector<Point<frames::Ct>>& targets);

/// Names of the columns of to_csv(), with a line end.
std::string csv_header();
/// One line for each trial with all its data.
std::string to_csv(const std::vector<Trial>& trials);

}  // namespace nav::bench
