// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/trials.hpp"

#include <Eigen/Dense>
#include <sstream>

#include "bench/registration/thread_time.hpp"
#include "nav/check.hpp"
#include "registration/acceptance.hpp"
#include "registration/prepared.hpp"

namespace nav::bench {
namespace {

using registration::ImageRegistrationOptions;
using registration::ImageRegistrationResult;
using registration::PreparedCt;
using registration::PreparedSweep;

// 95 % quantile of a chi-squared variable with three degrees of freedom.
constexpr double kChi95 = 7.815;

/// Fraction of the targets whose error lies inside the predicted 95 % ellipsoid.
double covered(const registration::PoseUncertainty& uncertainty, const CtPose& found_pose,
               const CtPose& truth, const std::vector<Point<frames::Ct>>& targets) {
  const auto back = truth.inverse();
  double inside = 0;
  for (const auto& target : targets) {
    const Point<frames::Ct> found = found_pose * (back * target);
    const Eigen::Vector3d error = (found - target).v;
    const Eigen::Matrix3d spread = uncertainty.tre_covariance(found);
    inside += error.dot(spread.ldlt().solve(error)) <= kChi95 ? 1 : 0;
  }
  return inside / static_cast<double>(targets.size());
}

/// All trials of one sweep.
class SweepTrials {
 public:
  SweepTrials(const CohortOptions& options, CaseStore& store, std::uint64_t patient_seed,
              SweepPath path)
      : options_(options),
        store_(store),
        path_(path),
        patient_(store.patient(patient_seed)),
        recorded_(store.sweep(patient_seed, path, options.frames)),
        ct_(store.ready_ct(patient_seed, options.global)) {}

  std::vector<Trial> run() {
    const Sweep thinned = every(options_.image_stride, recorded_->sweep);
    std::optional<PreparedSweep> sweep;
    const double sweep_cpu_s = timed([&] { sweep = prepare(thinned); });
    for (const bool global : {false, true}) {
      for (const double mm : global ? options_.global_mm : options_.local_mm) {
        for (int start = 0; start < options_.starts; ++start) {
          Trial trial = blank(global, mm);
          trial.sweep_cpu_s = sweep_cpu_s;
          if (sweep) {
            solve(ct_->prepared, *sweep, start_of(mm, start), trial);
          } else {
            trial.reason = refusal_;
          }
          out_.push_back(std::move(trial));
        }
      }
    }
    if (options_.hopeless) run_all_hopeless();
    return std::move(out_);
  }

 private:
  [[nodiscard]] CtPose start_of(double mm, int start) const {
    const std::uint64_t seed = 10000 * patient_->seed + 1000 * static_cast<std::uint64_t>(path_) +
                               10 * static_cast<std::uint64_t>(mm) +
                               static_cast<std::uint64_t>(start);
    return start_at(mm, patient_->truth, *recorded_, seed);
  }

  [[nodiscard]] Trial blank(bool global, double start_mm) const {
    Trial trial;
    trial.level = store_.level();
    trial.patient = patient_->seed;
    trial.path = path_;
    trial.global = global;
    trial.start_mm = start_mm;
    return trial;
  }

  std::optional<PreparedSweep> prepare(const Sweep& sweep) {
    CollectingDiagnostics diagnostics;
    auto made = PreparedSweep::create(sweep, options_.global, diagnostics);
    if (made) return std::move(*made);
    refusal_ = made.error().message;
    return {};
  }

  void solve(const PreparedCt& ct, const PreparedSweep& sweep, const CtPose& start,
             Trial& trial) const {
    const ImageRegistrationOptions& options = trial.global ? options_.global : options_.local;
    std::optional<Result<ImageRegistrationResult>> result;
    trial.solve_cpu_s =
        timed([&] { result = registration::register_prepared(ct, sweep, start, options); });
    trial.solved = result->has_value();
    if (trial.solved) {
      judge(**result, trial);
    } else {
      trial.reason = result->error().message;
    }
  }

  void judge(const ImageRegistrationResult& found, Trial& trial) const {
    const auto& targets = recorded_->targets;
    const auto target =
        found.ct_from_reference * (patient_->truth.inverse() * targets[targets.size() / 2]);
    const auto decision = registration::decide(found, options_.limits, target);
    trial.accepted = decision.accepted;
    trial.warned = decision.verdict() == registration::Verdict::kWarn;
    for (const auto& reason : decision.reasons) trial.reason += reason + "; ";
    trial.error_mm = target_error_mm(found.ct_from_reference, patient_->truth, targets);
    trial.predicted_mm = predicted_error_mm(found, targets);
    const auto share = [&](bool valid, const registration::PoseUncertainty& uncertainty) {
      return valid ? covered(uncertainty, found.ct_from_reference, patient_->truth, targets) : 0;
    };
    trial.covered = share(found.covariance_valid, found.uncertainty);
    trial.covered_clusters = share(found.covariance_valid, found.clusters);
    trial.covered_bootstrap = share(found.bootstrap.valid, found.bootstrap.uncertainty());
    trial.z_score = found.z_score;
    trial.cost = found.final_cost;
    trial.split_mm = found.split_disagreement_mm;
    trial.halves_mm = found.halves_disagreement_mm;
    trial.margin = found.margin;
    trial.overlap = found.overlap;
    trial.basin_mm = found.basin.shift_mm;
    trial.delay_ms = 1e3 * found.errors.delay_s;
    trial.delay_deviation_ms = 1e3 * found.error_deviations[0];
    for (const auto& misfit : found.misfits) {
      trial.excess_mm[static_cast<std::size_t>(misfit.cause)] = misfit.excess_mm();
    }
  }

  void run_all_hopeless() {
    const int first = static_cast<int>((patient_->seed + static_cast<std::uint64_t>(path_)) %
                                       static_cast<std::uint64_t>(options_.hopeless_stride));
    for (int kind = first; kind < kHopelessKinds; kind += options_.hopeless_stride) {
      run_hopeless(static_cast<Hopeless>(kind));
    }
  }

  void run_hopeless(Hopeless kind) {
    const auto other = store_.patient(patient_->seed + 1);
    const HopelessCase hopeless =
        make_hopeless(kind, *patient_, *other, *recorded_, 7 * patient_->seed + 1);
    const auto sweep = prepare(hopeless.sweep);
    std::shared_ptr<const ReadyCt> ct = ct_;
    std::optional<PreparedCt> changed;
    if (hopeless.ct == other->ct) {
      ct = store_.ready_ct(other->seed, options_.global);
    } else if (hopeless.ct != patient_->ct) {
      auto made = PreparedCt::create(*hopeless.ct, options_.global);
      NAV_CHECK(made.has_value());
      changed = std::move(*made);
    }
    for (const bool global : {false, true}) {
      if (!global && !options_.hopeless_local) continue;
      Trial trial = blank(global, kHopelessStartMm);
      trial.hopeless = kind;
      trial.acceptable = hopeless.may_be_right;
      if (sweep) {
        solve(changed ? *changed : ct->prepared, *sweep, hopeless.start, trial);
      } else {
        trial.reason = refusal_;
      }
      out_.push_back(std::move(trial));
    }
  }

  const CohortOptions& options_;
  CaseStore& store_;
  SweepPath path_;
  std::shared_ptr<const Patient> patient_;
  std::shared_ptr<const RecordedSweep> recorded_;
  std::shared_ptr<const ReadyCt> ct_;
  std::vector<Trial> out_;
  std::string refusal_;
};

}  // namespace

std::vector<Trial> run_sweep_trials(const CohortOptions& options, CaseStore& store,
                                    std::uint64_t patient_seed, SweepPath path) {
  return SweepTrials(options, store, patient_seed, path).run();
}

Sweep every(int stride, const Sweep& sweep) {
  std::vector<TrackedImage> kept;
  for (std::size_t i = 0; i < sweep.frames().size(); i += static_cast<std::size_t>(stride)) {
    kept.push_back(sweep.frames()[i]);
  }
  return std::move(Sweep::create(std::move(kept), sweep.calibration_id())).value();
}

double predicted_error_mm(const ImageRegistrationResult& result,
                          const std::vector<Point<frames::Ct>>& targets) {
  double sum = 0;
  for (const auto& target : targets) sum += std::pow(result.tre_rms_mm(target), 2);
  return std::sqrt(sum / static_cast<double>(targets.size()));
}

std::string csv_header() {
  return "level,patient,path,mode,start_mm,hopeless,acceptable,solved,accepted,warned,error_mm,"
         "predicted_mm,covered,covered_clusters,covered_bootstrap,solve_cpu_s,sweep_cpu_s,z_score,"
         "cost,overlap,split_mm,halves_mm,"
         "margin,basin_mm,delay_mm,pixel_size_mm,calibration_mm,motion_mm,bend_mm,delay_ms,delay_"
         "deviation_ms,reason\n";
}

std::string to_csv(const std::vector<Trial>& trials) {
  std::ostringstream text;
  for (const Trial& t : trials) {
    text << (t.level ? to_string(*t.level) : "") << ',' << t.patient << ',' << to_string(t.path)
         << ',' << (t.global ? "global" : "local") << ',' << t.start_mm << ','
         << (t.hopeless ? to_string(*t.hopeless) : "") << ',' << t.acceptable << ',' << t.solved
         << ',' << t.accepted << ',' << t.warned << ',' << t.error_mm << ',' << t.predicted_mm
         << ',' << t.covered << ',' << t.covered_clusters << ',' << t.covered_bootstrap << ','
         << t.solve_cpu_s << ',' << t.sweep_cpu_s << ',' << t.z_score << ',' << t.cost << ','
         << t.overlap << ',' << t.split_mm << ',' << t.halves_mm << ',';
    if (t.margin) text << *t.margin;
    text << ',' << t.basin_mm;
    for (const double excess_mm : t.excess_mm) text << ',' << excess_mm;
    text << ',' << t.delay_ms << ',' << t.delay_deviation_ms << ",\"" << t.reason << "\"\n";
  }
  return text.str();
}

}  // namespace nav::bench
