// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/fault_curve.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numeric>
#include <sstream>

#include "bench/measure.hpp"
#include "bench/registration/thread_time.hpp"
#include "registration/similarity/ct_structure.hpp"
#include "registration/uncertainty/sandwich.hpp"

namespace nav::bench {
namespace {

using registration::Decision;
using registration::ImageRegistrationOptions;
using registration::ImageRegistrationResult;
using registration::LocalShape;
using registration::MisfitCause;
using registration::PatchSet;
using registration::PreparedCt;
using registration::PreparedSweep;
using registration::SimilarityCost;

/// Time of find_misfits() alone, at the found pose with the patches of the last solve; absent if
/// nothing could be found.
std::optional<double> time_of_misfits_s(const PreparedCt& ct, const PreparedSweep& sweep,
                                        const registration::Pose& pose,
                                        const ImageRegistrationOptions& options) {
  const auto& channels = ct.levels();
  const auto& finest = sweep.levels().back();
  const auto* smoother = channels.size() > 1 ? channels[channels.size() - 2].get() : nullptr;
  const PatchSet patches = with_ct_structure(*channels.back(), finest.patches, pose,
                                             options.min_ct_contrast_hu, nullptr, smoother);
  const SimilarityCost cost =
      SimilarityCost(*channels.back(), patches, options.ridge, 1).robust(options.loss);
  const LocalShape shape =
      local_shape(cost, pose, pose * sweep.points().centroid,
                  registration::kCurvatureSteps * finest.options.sample_step_mm);
  std::vector<registration::Misfit> found;
  const double cpu_s = timed([&] { found = find_misfits(shape, patches, pose, sweep.motions()); });
  if (found.empty()) return {};
  return cpu_s;
}

/// The cause that was estimated with the pose and moves the images most; null: none is telling.
const registration::Misfit* likeliest_estimated(const std::vector<registration::Misfit>& misfits) {
  const registration::Misfit* most = nullptr;
  for (const registration::Misfit& one : misfits) {
    const double telling_mm = registration::kTellingMm[static_cast<std::size_t>(one.cause)];
    const bool told = !one.deviations.empty() && one.telling() && one.excess_mm() > telling_mm;
    if (told && (most == nullptr || one.excess_mm() > most->excess_mm())) most = &one;
  }
  return most;
}

std::optional<MisfitCause> named_by(const Decision& decision, const ImageRegistrationResult& result,
                                    const registration::AcceptanceLimits& limits) {
  const registration::Misfit* misfit = likeliest_misfit(result, limits);
  if (misfit == nullptr) misfit = likeliest_estimated(result.misfits);
  // Only accepted results have warnings.
  if (misfit == nullptr && decision.accepted) {
    misfit = likeliest_misfit(result, registration::kWarningLimits);
  }
  if (misfit == nullptr) return {};
  return misfit->cause;
}

FaultTrial run_fault(const Fault& fault, const FaultCase& one, const CohortOptions& settings) {
  FaultTrial trial;
  trial.fault = fault;
  CollectingDiagnostics diagnostics;
  const auto sweep = PreparedSweep::create(one.sweep, settings.global, diagnostics);
  if (!sweep) return trial;
  const auto result = register_prepared(one.ct->prepared, *sweep, one.start, settings.global);
  if (!result) return trial;
  const CtPose& found = result->ct_from_reference;
  const auto target = found * (one.truth.inverse() * one.lying[one.lying.size() / 2]);
  const Decision decision = decide(*result, settings.limits, target);
  trial.solved = true;
  trial.accepted = decision.accepted;
  trial.warned = decision.verdict() == registration::Verdict::kWarn;
  trial.error_mm = target_error_mm(found, one.truth, one.targets, one.lying);
  trial.predicted_mm = predicted_error_mm(*result, one.targets);
  trial.named = named_by(decision, *result, settings.limits);
  trial.misfits_cpu_s = time_of_misfits_s(one.ct->prepared, *sweep, found, settings.global);
  return trial;
}

/// Runs the faults patient by patient.
class FaultRunner {
 public:
  FaultRunner(const FaultCurveOptions& options, CaseStore& store,
              const std::function<void(double)>& progress)
      : options_(options),
        store_(store),
        progress_(progress),
        settings_(default_cohort(options.sweeps.effort)) {
    for (const Fault& fault : options.faults) {
      if (!in_patient(fault.kind)) of_sweeps_.push_back(fault);
      if (in_patient(fault.kind) || fault.kind == FaultKind::kNone) of_sessions_.push_back(fault);
    }
    all_ = options.sweeps.patients *
           static_cast<double>(options.sweeps.paths.size() * of_sweeps_.size() +
                               options.sweeps.hands.size() * of_sessions_.size());
  }

  Result<std::vector<FaultTrial>> run() {
    for (int patient = 0; patient < options_.sweeps.patients; ++patient) {
      const std::uint64_t seed = options_.sweeps.first_seed + static_cast<std::uint64_t>(patient);
      run_sweeps(seed);
      if (!options_.sweeps.keep) store_.forget(seed);
      if (auto ok = run_sessions(seed); !ok) return ok.error();
    }
    return std::move(trials_);
  }

 private:
  void run_sweeps(std::uint64_t seed) {
    if (of_sweeps_.empty()) return;
    const auto patient = store_.patient(seed);
    const auto ct = store_.ready_ct(seed, settings_.global);
    for (const SweepPath path : options_.sweeps.paths) {
      const auto recorded = store_.sweep(seed, path, settings_.frames);
      for (const Fault& fault : of_sweeps_) {
        add(run_fault(fault, fault_case(fault, *patient, *recorded, ct), settings_));
      }
    }
  }

  Result<void> run_sessions(std::uint64_t seed) {
    sim::SimulatedSessionOptions session;
    session.seed = seed;
    session.probe.model = options_.sweeps.model;
    session.duration_s = options_.sweeps.duration_s;
    std::shared_ptr<const ReadyCt> ct;  // CT of the patient at rest: the same in all sessions.
    for (const sim::HandPathKind hand : options_.sweeps.hands) {
      session.path.kind = hand;
      for (const Fault& fault : of_sessions_) {
        const auto made = make_faulty_session(fault, session);
        if (!made) return made.error();
        if (!ct) {
          auto prepared = PreparedCt::create(made->ct, settings_.global);
          if (!prepared) return prepared.error();
          ct = std::make_shared<const ReadyCt>(ReadyCt{std::move(*prepared), 0});
        }
        add(run_fault(fault, fault_case(*made, seed, ct), settings_));
      }
    }
    return {};
  }

  void add(const FaultTrial& trial) {
    trials_.push_back(trial);
    if (progress_) progress_(static_cast<double>(trials_.size()) / all_);
  }

  const FaultCurveOptions& options_;
  CaseStore& store_;
  const std::function<void(double)>& progress_;
  CohortOptions settings_;
  std::vector<Fault> of_sweeps_, of_sessions_;
  double all_ = 0;
  std::vector<FaultTrial> trials_;
};

/// Counts of all trials of one fault.
FaultPoint point_of(const Fault& fault, const std::vector<FaultTrial>& trials) {
  FaultPoint point;
  point.fault = fault;
  std::vector<double> errors, ratios, cpu_ms;
  for (const FaultTrial& trial : trials) {
    if (trial.fault != fault) continue;
    ++point.runs;
    point.refused += trial.accepted ? 0 : 1;
    point.false_accepts += trial.false_accept() ? 1 : 0;
    point.named += trial.named ? 1 : 0;
    point.named_right += trial.named && trial.named == cause_of(fault.kind) ? 1 : 0;
    if (!trial.solved) continue;
    ++point.solved;
    if (trial.misfits_cpu_s) cpu_ms.push_back(1e3 * *trial.misfits_cpu_s);
    if (!trial.accepted) continue;
    ++(trial.warned ? point.warned : point.clear);
    errors.push_back(trial.error_mm);
    ratios.push_back(trial.error_mm / trial.predicted_mm);
  }
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const auto accepted = static_cast<double>(errors.size());
  const double sum = std::accumulate(errors.begin(), errors.end(), 0.0);
  point.error_mean_mm = errors.empty() ? kNone : sum / accepted;
  point.error_max_mm = errors.empty() ? kNone : *std::ranges::max_element(errors);
  point.actual_over_predicted = median(ratios);
  point.misfits_cpu_ms = median(cpu_ms);
  return point;
}

/// "-" for a missing value.
std::string cell(double value, int digits) {
  if (!std::isfinite(value)) return "-";
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << value;
  return text.str();
}

}  // namespace

std::vector<FaultPoint> count_faults(const std::vector<FaultTrial>& trials) {
  std::vector<FaultPoint> points;
  for (const FaultTrial& trial : trials) {
    const bool known = std::ranges::any_of(
        points, [&](const FaultPoint& point) { return point.fault == trial.fault; });
    if (!known) points.push_back(point_of(trial.fault, trials));
  }
  return points;
}

Result<std::vector<FaultTrial>> run_faults(const FaultCurveOptions& options, CaseStore& store,
                                           const std::function<void(double)>& progress) {
  return FaultRunner(options, store, progress).run();
}

std::string to_text(const std::vector<FaultPoint>& points, const std::string& title) {
  std::ostringstream text;
  text << "\nfaults, " << title << ": target error of accepted results, mm, RMS over the targets\n"
       << "                                                                      actual/  cause  "
          "misfits\n"
       << "  fault        size             runs solved clear warned refused false  mean   max "
          "predicted  right   cpu ms\n";
  int runs = 0;
  int false_accepts = 0;
  for (const FaultPoint& p : points) {
    runs += p.runs;
    false_accepts += p.false_accepts;
    const bool none = p.fault.kind == FaultKind::kNone;
    // Without a fault no cause is right, so only the number of named causes is printed.
    const std::string right = none ? std::to_string(p.named) + " named"
                                   : std::to_string(p.named_right) + '/' + std::to_string(p.named);
    text << "  " << std::left << std::setw(13) << to_string(p.fault.kind) << std::setw(15)
         << size_in_words(p.fault) << std::right << std::setw(6) << p.runs << std::setw(7)
         << p.solved << std::setw(6) << p.clear << std::setw(7) << p.warned << std::setw(8)
         << p.refused << std::setw(6) << p.false_accepts << std::setw(6) << cell(p.error_mean_mm, 2)
         << std::setw(6) << cell(p.error_max_mm, 2) << std::setw(10)
         << cell(p.actual_over_predicted, 2) << std::setw(9) << right << std::setw(7)
         << cell(p.misfits_cpu_ms, 1) << '\n';
  }
  text << "  false accepts (above " << kFalseAcceptMm << " mm): " << false_accepts << " of " << runs
       << " runs\n";
  return text.str();
}

}  // namespace nav::bench
