// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <mutex>
#include <thread>

#include "bench/registration/trials.hpp"
#include "nav/check.hpp"

namespace nav::bench {
namespace {

/// Distributes sweeps to threads and collects their trials.
class CohortRunner {
 public:
  CohortRunner(const CohortOptions& options, CaseStore& store,
               const std::function<void(double)>& progress,
               const std::function<void(const std::vector<Trial>&)>& done)
      : options_(options),
        store_(store),
        progress_(progress),
        done_(done),
        left_(static_cast<std::size_t>(options.patients), 0) {
    const auto stride = static_cast<std::size_t>(options.path_stride);
    for (std::size_t patient = 0; patient < left_.size(); ++patient) {
      for (std::size_t path = patient % stride; path < options.paths.size(); path += stride) {
        sweeps_.push_back({patient, options.paths[path]});
        ++left_[patient];
      }
    }
    trials_.resize(sweeps_.size());
  }

  CohortResult run() {
    std::vector<std::thread> helpers;
    for (int i = 1; i < options_.threads; ++i) helpers.emplace_back([this] { work(false); });
    work(true);
    for (std::thread& helper : helpers) helper.join();
    CohortResult result;
    for (auto& of_sweep : trials_) {
      for (Trial& trial : of_sweep) result.trials.push_back(std::move(trial));
    }
    result.ct_cpu_s = std::move(ct_cpu_s_);
    return result;
  }

 private:
  [[nodiscard]] std::uint64_t seed_of(std::size_t patient) const {
    return options_.first_seed + patient;
  }

  /// main: true on the calling thread, which reports the progress.
  void work(bool main) {
    for (std::size_t i = next_++; i < sweeps_.size(); i = next_++) {
      const auto& [patient, path] = sweeps_[i];
      auto trials = run_sweep_trials(options_, store_, seed_of(patient), path);
      const auto ct = store_.ready_ct(seed_of(patient), options_.global);
      const std::lock_guard lock(mutex_);
      if (done_) done_(trials);
      trials_[i] = std::move(trials);
      finish(patient, ct->cpu_s);
      if (main && progress_) {
        progress_(static_cast<double>(finished_) / static_cast<double>(sweeps_.size()));
      }
    }
  }

  /// A patient's CT is also the wrong CT for the patient before: both must have finished with it.
  void finish(std::size_t patient, double ct_cpu_s) {
    ++finished_;
    if (--left_[patient] == 0) ct_cpu_s_.push_back(ct_cpu_s);
    if (options_.keep) return;
    for (std::size_t p = 0; p < left_.size(); ++p) {
      if (left_[p] == 0 && (p == 0 || left_[p - 1] == 0)) store_.forget(seed_of(p));
    }
  }

  const CohortOptions& options_;
  CaseStore& store_;
  const std::function<void(double)>& progress_;
  const std::function<void(const std::vector<Trial>&)>& done_;
  std::vector<std::pair<std::size_t, SweepPath>> sweeps_;  // Patient index from first_seed on.
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;  // Protects all members below.
  std::vector<std::vector<Trial>> trials_;
  std::vector<std::size_t> left_;
  std::vector<double> ct_cpu_s_;
  std::size_t finished_ = 0;
};

}  // namespace

CohortOptions default_cohort(registration::Effort effort) {
  CohortOptions options;
  options.local = options.global = registration::with_effort(effort);
  options.limits = registration::limits_for(effort);
  options.local.starts = 0;
  options.local.threads = options.global.threads = 1;
  // The cohort's calibration is exact.
  options.local.calibration_sigma_mm = options.global.calibration_sigma_mm = 0;
  return options;
}

CohortResult run_cohort(const CohortOptions& options, CaseStore& store,
                        const std::function<void(double)>& progress,
                        const std::function<void(const std::vector<Trial>&)>& done) {
  NAV_CHECK(options.patients >= 1 && options.starts >= 1, options.patients, options.starts);
  NAV_CHECK(options.hopeless_stride >= 1 && options.image_stride >= 1 && options.path_stride >= 1);
  NAV_CHECK(options.threads >= 1 && !options.paths.empty(), options.threads);
  return CohortRunner(options, store, progress, done).run();
}

}  // namespace nav::bench
