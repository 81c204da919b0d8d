// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/start_curve.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <memory>
#include <sstream>
#include <utility>

#include "bench/measure.hpp"
#include "bench/registration/fault_case.hpp"
#include "nav/check.hpp"

namespace nav::bench {
namespace {

using registration::ImageRegistrationResult;
using registration::MisfitCause;
using registration::PreparedCt;
using registration::PreparedSweep;

/// A sweep and the truth that starts are measured from.
struct StartCase {
  const Sweep& sweep;
  const CtPose& truth;
  const std::vector<Point<frames::Ct>>& targets;
  std::uint64_t seed;  ///< Seed of the starts.
};

std::optional<double> hidden_mm(const ImageRegistrationResult& result) {
  for (const registration::Misfit& misfit : result.misfits) {
    if (misfit.cause == MisfitCause::kCalibration) return misfit.unnoticed;
  }
  return {};
}

StartTrial judged(const ImageRegistrationResult& result, const StartCase& one,
                  const registration::AcceptanceLimits& limits) {
  const auto target =
      result.ct_from_reference * (one.truth.inverse() * one.targets[one.targets.size() / 2]);
  return {.pose = result.ct_from_reference,
          .cost = result.final_cost,
          .accepted = decide(result, limits, target).accepted,
          .predicted_mm = predicted_error_mm(result, one.targets),
          .hidden_mm = hidden_mm(result)};
}

StartSweep from_all_starts(const StartCase& one, const PreparedCt& ct,
                           const StartCurveOptions& options) {
  const CohortOptions settings = default_cohort(options.sweeps.effort);
  StartSweep out;
  for (const auto& target : one.targets) out.targets.push_back(one.truth.inverse() * target);
  CollectingDiagnostics diagnostics;
  const auto sweep = PreparedSweep::create(one.sweep, settings.global, diagnostics);
  if (!sweep) return out;
  for (std::size_t i = 0; i < options.starts_mm.size(); ++i) {
    const CtPose start = start_at(options.starts_mm[i], one.truth,
                                  {SweepPath::kSlide, one.sweep, one.targets}, one.seed + i);
    const auto result = register_prepared(ct, *sweep, start, settings.global);
    if (result) out.trials.push_back(judged(*result, one, settings.limits));
  }
  return out;
}

/// Runs the starts patient by patient.
class StartRunner {
 public:
  StartRunner(const StartCurveOptions& options, CaseStore& store,
              const std::function<void(double)>& progress)
      : options_(options), store_(store), progress_(progress) {}

  Result<std::vector<StartSweep>> run() {
    for (int patient = 0; patient < options_.sweeps.patients; ++patient) {
      const std::uint64_t seed = options_.sweeps.first_seed + static_cast<std::uint64_t>(patient);
      run_sweeps(seed);
      if (!options_.sweeps.keep) store_.forget(seed);
      if (auto ok = run_sessions(seed); !ok) return ok.error();
    }
    if (!options_.sweeps.keep) {
      store_.forget(options_.sweeps.first_seed +
                    static_cast<std::uint64_t>(options_.sweeps.patients));
    }
    return std::move(sweeps_);
  }

 private:
  void run_sweeps(std::uint64_t seed) {
    const CohortOptions settings = default_cohort(options_.sweeps.effort);
    const auto patient = store_.patient(seed);
    for (const SweepPath path : options_.sweeps.paths) {
      const auto recorded = store_.sweep(seed, path, settings.frames);
      const StartCase one{recorded->sweep, patient->truth, recorded->targets,
                          10000 * seed + 100 * static_cast<std::uint64_t>(path)};
      for (const bool own : {true, false}) {
        const auto ct = store_.ready_ct(own ? seed : seed + 1, settings.global);
        add(to_string(path), own, from_all_starts(one, ct->prepared, options_));
      }
    }
  }

  Result<void> run_sessions(std::uint64_t seed) {
    sim::SimulatedSessionOptions session;
    session.seed = seed;
    session.probe.model = options_.sweeps.model;
    session.duration_s = options_.sweeps.duration_s;
    std::optional<PreparedCt> ct;  // CT of the patient at rest: the same in all sessions.
    for (const sim::HandPathKind hand : options_.sweeps.hands) {
      session.path.kind = hand;
      const auto made = make_faulty_session({}, session);
      if (!made) return made.error();
      if (!ct) {
        auto prepared = PreparedCt::create(made->ct, default_cohort(options_.sweeps.effort).global);
        if (!prepared) return prepared.error();
        ct = std::move(*prepared);
      }
      const FaultCase usual = fault_case(*made, seed, nullptr);
      const StartCase one{usual.sweep, usual.truth, usual.targets,
                          10000 * seed + 1000 * (1 + static_cast<std::uint64_t>(hand))};
      add(std::string("session ") + sim::to_string(hand), true,
          from_all_starts(one, *ct, options_));
    }
    return {};
  }

  void add(const std::string& path, bool own, StartSweep sweep) {
    sweep.path = path;
    sweep.own_ct = own;
    sweeps_.push_back(std::move(sweep));
    const auto all =
        options_.sweeps.patients *
        static_cast<double>(2 * options_.sweeps.paths.size() + options_.sweeps.hands.size());
    if (progress_) progress_(static_cast<double>(sweeps_.size()) / all);
  }

  const StartCurveOptions& options_;
  CaseStore& store_;
  const std::function<void(double)>& progress_;
  std::vector<StartSweep> sweeps_;
};

/// Counts of one sweep, for its results at the pose of the lowest cost.
struct OfSweep {
  int same = 0, accepted = 0, elsewhere = 0;
  double apart_mm = 0;
  double predicted_ratio = 1;
  std::optional<double> hidden_mm;
};

OfSweep at_cheapest(const StartSweep& sweep) {
  const StartTrial& best =
      *std::min_element(sweep.trials.begin(), sweep.trials.end(),
                        [](const StartTrial& a, const StartTrial& b) { return a.cost < b.cost; });
  std::vector<Point<frames::Ct>> targets;
  for (const auto& target : sweep.targets) targets.push_back(best.pose * target);
  OfSweep out;
  out.hidden_mm = best.hidden_mm;
  double least = best.predicted_mm;
  double most = best.predicted_mm;
  for (const StartTrial& trial : sweep.trials) {
    const double apart_mm = target_error_mm(trial.pose, best.pose, targets);
    if (!(apart_mm <= kSamePoseMm)) {
      out.elsewhere += trial.accepted ? 1 : 0;
      continue;
    }
    ++out.same;
    out.accepted += trial.accepted ? 1 : 0;
    out.apart_mm = std::max(out.apart_mm, apart_mm);
    least = std::min(least, trial.predicted_mm);
    most = std::max(most, trial.predicted_mm);
  }
  // Both infinite: nothing is predicted from any start, so the starts agree.
  out.predicted_ratio = most == least ? 1 : most / least;
  return out;
}

StartPoint counted(const std::vector<const StartSweep*>& sweeps) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  StartPoint out{sweeps.front()->path, sweeps.front()->own_ct};
  std::vector<double> apart, ratios, hidden;
  for (const StartSweep* sweep : sweeps) {
    ++out.sweeps;
    out.registrations += static_cast<int>(sweep->trials.size());
    if (sweep->trials.empty()) continue;
    const OfSweep of = at_cheapest(*sweep);
    out.same += of.same;
    out.accepted += of.accepted;
    out.elsewhere += of.elsewhere;
    out.split += of.accepted > 0 && of.accepted < of.same ? 1 : 0;
    apart.push_back(of.apart_mm);
    ratios.push_back(of.predicted_ratio);
    if (of.hidden_mm) hidden.push_back(*of.hidden_mm);
  }
  const auto most = [](const std::vector<double>& of) {
    return of.empty() ? kNan : *std::max_element(of.begin(), of.end());
  };
  out.apart_mm = median(apart);
  out.apart_max_mm = most(apart);
  out.predicted_ratio = median(ratios);
  out.predicted_ratio_max = most(ratios);
  out.hidden_least_mm = hidden.empty() ? kNan : *std::min_element(hidden.begin(), hidden.end());
  out.hidden_most_mm = most(hidden);
  return out;
}

}  // namespace

std::vector<StartPoint> count_starts(const std::vector<StartSweep>& sweeps) {
  std::vector<std::vector<const StartSweep*>> groups;
  for (const StartSweep& sweep : sweeps) {
    const auto at = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
      return group.front()->path == sweep.path && group.front()->own_ct == sweep.own_ct;
    });
    if (at != groups.end()) {
      at->push_back(&sweep);
    } else {
      groups.push_back({&sweep});
    }
  }
  std::vector<StartPoint> out;
  for (const auto& group : groups) out.push_back(counted(group));
  return out;
}

Result<std::vector<StartSweep>> run_starts(const StartCurveOptions& options, CaseStore& store,
                                           const std::function<void(double)>& progress) {
  NAV_CHECK(options.sweeps.patients >= 1 && !options.starts_mm.empty(), options.sweeps.patients);
  return StartRunner(options, store, progress).run();
}

std::string to_text(const std::vector<StartPoint>& points) {
  std::ostringstream text;
  text << std::fixed << "\none sweep from several starts: verdicts at the same pose\n";
  for (const StartPoint& p : points) {
    text << "  " << std::setw(13) << std::left << p.path << std::right
         << (p.own_ct ? "own CT" : "other CT") << ": " << p.sweeps << " sweeps, " << p.same
         << " of " << p.registrations << " at the cheapest pose (within " << std::setprecision(2)
         << p.apart_max_mm << " mm), accepted " << p.accepted << " (and " << p.elsewhere
         << " elsewhere), two verdicts in " << p.split << ", predicted errors up to "
         << p.predicted_ratio << " times each other (median), " << p.predicted_ratio_max
         << " (most)";
    if (p.own_ct) {
      text << "; calibration hides " << std::setprecision(1) << p.hidden_least_mm << " to "
           << p.hidden_most_mm << " mm";
    }
    text << '\n';
  }
  return text.str();
}

}  // namespace nav::bench
