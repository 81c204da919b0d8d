// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/registration/hopeless.hpp"
#include "registration/image_registration.hpp"

namespace nav::bench {

/// A result is right when its targets are off by less than this, RMS.
inline constexpr double kSuccessMm = 2;
/// An accepted one that is off by more is a false accept.
inline constexpr double kFalseAcceptMm = 3;

/// What one registration did.
struct Trial {
  std::uint64_t patient = 0;
  SweepPath path = SweepPath::kSubcostal;
  bool global = false;               ///< With seeded starts; false: the plain solve.
  double start_mm = 0;               ///< Target error of the start.
  std::optional<Hopeless> hopeless;  ///< Absent: a start that should succeed.
  bool acceptable = true;            ///< False: no pose of this case is right.
  bool solved = false;               ///< False: refused before a pose was found.
  bool accepted = false;
  double error_mm = 0;      ///< At the targets, RMS; meaningless unless solved and acceptable.
  double predicted_mm = 0;  ///< The same as predicted; infinite where nothing is predicted.
  double covered = 0;       ///< Share of the targets inside their 95 % ellipsoid.
  double solve_cpu_s = 0;   ///< With CT and sweep prepared.
  double sweep_cpu_s = 0;   ///< Preparation of the sweep.
  std::string reason;       ///< Why it was refused; empty when accepted.
  /// What the decision rests on (registration/image_registration.hpp).
  double z_score = 0, cost = 1, overlap = 0, split_mm = 0, halves_mm = 0;
  std::optional<double> margin;

  [[nodiscard]] bool right(double limit_mm = kSuccessMm) const {
    return solved && acceptable && error_mm < limit_mm;
  }
  [[nodiscard]] bool false_accept() const { return accepted && !right(kFalseAcceptMm); }
};

/// Which trials to run on patients of consecutive seeds.
struct CohortOptions {
  std::uint64_t first_seed = 1;
  int patients = 8;
  std::vector<SweepPath> paths{SweepPath::kSubcostal, SweepPath::kFan, SweepPath::kSlide,
                               SweepPath::kSagittal, SweepPath::kCross};
  std::vector<double> local_mm{5, 10};
  std::vector<double> global_mm{5, 10, 20, 30, 40, 60};
  int starts = 2;           ///< Of each distance.
  bool hopeless = true;     ///< Every kind on every sweep, global.
  int hopeless_stride = 1;  ///< Of the kinds only every so many-th, others on each sweep; >= 1.
  int frames = 60;          ///< Of a sweep.
  registration::ImageRegistrationOptions local, global;
};

/// Settings of the bench: the library's, one thread.
CohortOptions default_cohort();

struct CohortResult {
  std::vector<Trial> trials;
  std::vector<double> ct_cpu_s;  ///< Preparation of each patient's CT.
};

/// Runs the cohort patient by patient: no more than two patients are in memory.
CohortResult run_cohort(const CohortOptions& options,
                        const std::function<void(double)>& progress = {});

}  // namespace nav::bench
