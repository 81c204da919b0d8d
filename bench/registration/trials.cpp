// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/trials.hpp"

#include <Eigen/Dense>

#include "bench/measure.hpp"
#include "nav/check.hpp"
#include "registration/acceptance.hpp"
#include "registration/prepared.hpp"

namespace nav::bench {
namespace {

using registration::ImageRegistrationOptions;
using registration::ImageRegistrationResult;
using registration::PreparedCt;
using registration::PreparedSweep;

// 95 % of a chi-squared variable of three degrees of freedom.
constexpr double kChi95 = 7.815;

template <class Work>
double timed(const Work& work) {
  const double before = process_time_s();
  work();
  return process_time_s() - before;
}

/// Share of the targets whose error lies inside the predicted 95 % ellipsoid.
double covered(const ImageRegistrationResult& result, const CtPose& truth,
               const std::vector<Point<frames::Ct>>& targets) {
  const auto back = truth.inverse();
  double inside = 0;
  for (const auto& target : targets) {
    const Point<frames::Ct> found = result.ct_from_reference * (back * target);
    const Eigen::Vector3d error = (found - target).v;
    const Eigen::Matrix3d spread = result.uncertainty.tre_covariance(found);
    inside += error.dot(spread.ldlt().solve(error)) <= kChi95 ? 1 : 0;
  }
  return inside / static_cast<double>(targets.size());
}

double predicted(const ImageRegistrationResult& result,
                 const std::vector<Point<frames::Ct>>& targets) {
  double sum = 0;
  for (const auto& target : targets) sum += std::pow(result.tre_rms_mm(target), 2);
  return std::sqrt(sum / static_cast<double>(targets.size()));
}

/// All trials of one patient.
class PatientTrials {
 public:
  PatientTrials(const CohortOptions& options, const Patient& patient, const Patient& other,
                CohortResult& out)
      : options_(options), patient_(patient), other_(other), out_(out) {
    ct_ = prepare(*patient.ct);
  }

  void run(SweepPath path) {
    const auto index = static_cast<std::uint64_t>(path);
    const RecordedSweep recorded =
        record_sweep(patient_, {path, 100 * patient_.seed + index, options_.frames});
    std::optional<PreparedSweep> sweep;
    const double sweep_cpu_s = timed([&] { sweep = prepare(recorded.sweep); });
    NAV_CHECK(sweep.has_value(), patient_.seed, to_string(path));
    for (const bool global : {false, true}) {
      for (const double mm : global ? options_.global_mm : options_.local_mm) {
        for (int start = 0; start < options_.starts; ++start) {
          const std::uint64_t seed = 10000 * patient_.seed + 1000 * index +
                                     10 * static_cast<std::uint64_t>(mm) +
                                     static_cast<std::uint64_t>(start);
          Trial trial = blank(path, global, mm);
          trial.sweep_cpu_s = sweep_cpu_s;
          solve(*ct_, *sweep, start_at(mm, patient_.truth, recorded, seed), recorded, trial);
          out_.trials.push_back(std::move(trial));
        }
      }
    }
    if (!options_.hopeless) return;
    const int first = static_cast<int>((patient_.seed + index) %
                                       static_cast<std::uint64_t>(options_.hopeless_stride));
    for (int kind = first; kind < kHopelessKinds; kind += options_.hopeless_stride) {
      run_hopeless(static_cast<Hopeless>(kind), recorded);
    }
  }

 private:
  [[nodiscard]] Trial blank(SweepPath path, bool global, double start_mm) const {
    Trial trial;
    trial.patient = patient_.seed;
    trial.path = path;
    trial.global = global;
    trial.start_mm = start_mm;
    return trial;
  }

  std::optional<PreparedCt> prepare(const Volume& ct) {
    std::optional<PreparedCt> prepared;
    out_.ct_cpu_s.push_back(timed([&] {
      auto made = PreparedCt::create(ct, options_.global);
      NAV_CHECK(made.has_value(), made ? std::string() : made.error().message);
      prepared = std::move(*made);
    }));
    return prepared;
  }

  std::optional<PreparedSweep> prepare(const Sweep& sweep) {
    CollectingDiagnostics diagnostics;
    auto made = PreparedSweep::create(sweep, options_.global, diagnostics);
    if (!made) {
      refusal_ = made.error().message;
      return {};
    }
    return std::move(*made);
  }

  void solve(const PreparedCt& ct, const PreparedSweep& sweep, const CtPose& start,
             const RecordedSweep& recorded, Trial& trial) const {
    const ImageRegistrationOptions& options = trial.global ? options_.global : options_.local;
    std::optional<Result<ImageRegistrationResult>> result;
    trial.solve_cpu_s =
        timed([&] { result = registration::register_prepared(ct, sweep, start, options); });
    trial.solved = result->has_value();
    if (!trial.solved) {
      trial.reason = result->error().message;
      return;
    }
    const ImageRegistrationResult& found = **result;
    const auto target = found.ct_from_reference *
                        (patient_.truth.inverse() * recorded.targets[recorded.targets.size() / 2]);
    const auto decision = registration::decide(found, {}, target);
    trial.accepted = decision.accepted;
    for (const auto& reason : decision.reasons) trial.reason += reason + "; ";
    trial.error_mm = target_error_mm(found.ct_from_reference, patient_.truth, recorded.targets);
    trial.predicted_mm = predicted(found, recorded.targets);
    trial.covered = found.covariance_valid ? covered(found, patient_.truth, recorded.targets) : 0;
    trial.z_score = found.z_score;
    trial.cost = found.final_cost;
    trial.split_mm = found.split_disagreement_mm;
    trial.halves_mm = found.halves_disagreement_mm;
    trial.margin = found.margin;
    trial.overlap = found.overlap;
  }

  void run_hopeless(Hopeless kind, const RecordedSweep& recorded) {
    const HopelessCase hopeless =
        make_hopeless(kind, patient_, other_, recorded, 7 * patient_.seed + 1);
    Trial trial = blank(recorded.path, true, kHopelessStartMm);
    trial.hopeless = kind;
    trial.acceptable = hopeless.may_be_right;
    const auto sweep = prepare(hopeless.sweep);
    if (!sweep) {
      trial.reason = refusal_;
    } else if (hopeless.ct == patient_.ct) {
      solve(*ct_, *sweep, hopeless.start, recorded, trial);
    } else {
      auto made = PreparedCt::create(*hopeless.ct, options_.global);
      NAV_CHECK(made.has_value());
      solve(*made, *sweep, hopeless.start, recorded, trial);
    }
    out_.trials.push_back(std::move(trial));
  }

  const CohortOptions& options_;
  const Patient& patient_;
  const Patient& other_;
  CohortResult& out_;
  std::optional<PreparedCt> ct_;
  std::string refusal_;
};

}  // namespace

CohortOptions default_cohort() {
  CohortOptions options;
  options.local.starts = 0;
  options.local.threads = options.global.threads = 1;
  return options;
}

CohortResult run_cohort(const CohortOptions& options, const std::function<void(double)>& progress) {
  NAV_CHECK(options.patients >= 1 && options.starts >= 1, options.patients, options.starts);
  NAV_CHECK(options.hopeless_stride >= 1, options.hopeless_stride);
  CohortResult result;
  const auto count = static_cast<std::size_t>(options.patients);
  auto patient = std::make_unique<Patient>(make_patient(options.first_seed));
  for (std::size_t i = 0; i < count; ++i) {
    // The next one's CT is what this one's is confused with.
    auto next = std::make_unique<Patient>(make_patient(options.first_seed + i + 1));
    PatientTrials trials(options, *patient, *next, result);
    for (std::size_t p = 0; p < options.paths.size(); ++p) {
      trials.run(options.paths[p]);
      if (!progress) continue;
      const auto done = static_cast<double>(i * options.paths.size() + p + 1);
      progress(done / static_cast<double>(count * options.paths.size()));
    }
    patient = std::move(next);
  }
  return result;
}

}  // namespace nav::bench
