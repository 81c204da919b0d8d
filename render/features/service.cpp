// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/service.hpp"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <list>
#include <map>
#include <mutex>
#include <thread>

namespace nav::render::features {

/// A requested computation. Its own lock protects everything that is not atomic.
struct DerivedVolumes::Job {
  Job(DerivedRequest r, std::string k) : request(std::move(r)), key(std::move(k)) {}
  /// Used by the worker and cleared when finished, so that only the result stays in memory.
  std::optional<DerivedRequest> request;
  const std::string key;
  std::stop_source stop;
  std::atomic<double> progress = 0;
  std::mutex mutex;
  std::condition_variable finished;
  std::optional<Result<DerivedVolume>> result;
  std::exception_ptr thrown;  ///< Thrown instead of the result, which is then set too.
  int interested = 0;

  void finish(Result<DerivedVolume> value) {
    const std::lock_guard lock(mutex);
    result = std::move(value);
    progress = 1;
    finished.notify_all();
  }
  /// Returns the result of the computation, or throws what it threw. Call locked, once there is a
  /// result.
  [[nodiscard]] const Result<DerivedVolume>& outcome() const {
    if (thrown) std::rethrow_exception(thrown);
    return *result;
  }
  /// Adds interest. False if it is too late: nobody was interested and the job is being stopped.
  bool join() {
    const std::lock_guard lock(mutex);
    if (!result && interested == 0 && stop.stop_requested()) return false;
    ++interested;
    return true;
  }
  void leave() {
    const std::lock_guard lock(mutex);
    if (--interested == 0 && !result) stop.request_stop();
  }
};

DerivedVolumes::Ticket& DerivedVolumes::Ticket::operator=(Ticket&& other) noexcept {
  if (this != &other) {
    if (job_) cancel();
    job_ = std::move(other.job_);
    interested_ = other.interested_;
  }
  return *this;
}

DerivedVolumes::Ticket::~Ticket() {
  if (job_) cancel();
}

double DerivedVolumes::Ticket::progress() const { return job_->progress; }

std::optional<Result<DerivedVolume>> DerivedVolumes::Ticket::poll() const {
  const std::lock_guard lock(job_->mutex);
  if (!job_->result) return {};
  return job_->outcome();
}

Result<DerivedVolume> DerivedVolumes::Ticket::wait() const {
  std::unique_lock lock(job_->mutex);
  job_->finished.wait(lock, [&] { return job_->result.has_value(); });
  return job_->outcome();
}

bool DerivedVolumes::Ticket::wait_for(std::chrono::milliseconds most) const {
  std::unique_lock lock(job_->mutex);
  return job_->finished.wait_for(lock, most, [&] { return job_->result.has_value(); });
}

void DerivedVolumes::Ticket::cancel() {
  if (interested_) job_->leave();
  interested_ = false;
}

/// Queue and cache. Order of locks: this one first, then a job's.
struct DerivedVolumes::State {
  State(const DerivedLimits& l, Compute c) : limits(l), compute(std::move(c)) {}

  const DerivedLimits limits;
  const Compute compute;
  mutable std::mutex mutex;
  std::condition_variable_any wake;
  std::deque<std::shared_ptr<Job>> queue;
  std::shared_ptr<Job> running;
  std::list<std::shared_ptr<Job>> kept;  ///< Successful jobs, the most recently used first.
  Counts counts;
  std::jthread worker;  ///< Last member: its end is waited for first.

  static std::size_t bytes_of(const Job& job) {
    return (**job.result).volume.values->size() * sizeof(float);
  }
  /// Finds a finished, running or waiting job with a key that can still be joined. Call locked.
  std::shared_ptr<Job> find(const std::string& key) {
    for (auto at = kept.begin(); at != kept.end(); ++at) {
      if ((*at)->key != key) continue;
      kept.splice(kept.begin(), kept, at);
      return kept.front()->join() ? kept.front() : nullptr;
    }
    if (running && running->key == key && running->join()) return running;
    for (const auto& job : queue) {
      if (job->key == key && job->join()) return job;
    }
    return nullptr;
  }
  /// Adds a job to the cache. Call locked.
  void keep(const std::shared_ptr<Job>& job) {
    kept.push_front(job);
    counts.cached_bytes += bytes_of(*job);
    while (counts.cached_bytes > limits.cache_bytes && kept.size() > 1) {
      counts.cached_bytes -= bytes_of(*kept.back());
      kept.pop_back();
    }
  }
  void run(const std::stop_token& quit) {
    while (true) {
      {
        std::unique_lock lock(mutex);
        if (!wake.wait(lock, quit, [&] { return !queue.empty(); })) break;
        running = queue.front();
        queue.pop_front();
      }
      Result<DerivedVolume> value = work_on(running);
      // Stored before anyone can know of the result, so that the next request finds it.
      const std::lock_guard lock(mutex);
      running->request.reset();
      running->finish(std::move(value));
      if (running->result->has_value()) keep(running);
      running.reset();
    }
    const std::lock_guard lock(mutex);
    for (const auto& job : queue) {
      job->request.reset();
      job->finish(cancelled("derived volume"));
    }
    queue.clear();
  }
  Result<DerivedVolume> work_on(const std::shared_ptr<Job>& job) {
    if (job->stop.stop_requested()) return cancelled("derived volume");
    {
      const std::lock_guard lock(mutex);
      ++counts.computed;
    }
    RunOptions how;
    how.threads = limits.threads;
    how.memory_limit = limits.memory_limit;
    how.stop = job->stop.get_token();
    // Workers report in any order; the displayed share never falls.
    how.progress = [&job](double share) {
      double shown = job->progress;
      while (share > shown && !job->progress.compare_exchange_weak(shown, share)) {
      }
    };
    try {
      return compute(*job->request, how);
    } catch (const std::bad_alloc&) {
      return Error{ErrorCode::kUnavailable,
                   job->request->volume.name() + ": out of memory for a derived volume"};
    } catch (...) {
      job->thrown = std::current_exception();
      return Error{
          ErrorCode::kUnavailable,
          job->request->volume.name() + ": an exception ended the computation of a derived volume"};
    }
  }
};

DerivedVolumes::DerivedVolumes(const DerivedLimits& limits, Compute compute)
    : state_(std::make_unique<State>(limits, std::move(compute))) {
  state_->worker =
      std::jthread([state = state_.get()](const std::stop_token& quit) { state->run(quit); });
}

DerivedVolumes::~DerivedVolumes() {
  {
    const std::lock_guard lock(state_->mutex);
    if (state_->running) state_->running->stop.request_stop();
    for (const auto& job : state_->queue) job->stop.request_stop();
  }
  state_->worker.request_stop();
  state_->worker.join();
}

Result<DerivedVolumes::Ticket> DerivedVolumes::request(const DerivedRequest& request) {
  if (const auto ok = validate(request); !ok) return ok.error();
  const std::string key = key_of(request);
  const std::lock_guard lock(state_->mutex);
  if (auto job = state_->find(key)) {
    ++state_->counts.found;
    return Ticket(std::move(job));
  }
  auto job = std::make_shared<Job>(request, key);
  job->interested = 1;
  state_->queue.push_back(job);
  state_->wake.notify_one();
  return Ticket(std::move(job));
}

DerivedVolumes::Counts DerivedVolumes::counts() const {
  const std::lock_guard lock(state_->mutex);
  return state_->counts;
}

}  // namespace nav::render::features
