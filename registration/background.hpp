// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <optional>
#include <thread>
#include <utility>

#include "nav/result.hpp"

namespace nav::registration {

/// A registration on its own thread. It runs any function that takes `progress` as register_sweep()
/// does. All members are thread-safe except wait() and poll(), which must be called from one
/// thread.
template <class T>
class InBackground {
 public:
  using Progress = std::function<bool(double fraction)>;
  using Work = std::function<Result<T>(const Progress& progress)>;

  /// Begins at once. Everything that work refers to must outlive this object.
  explicit InBackground(Work work) {
    std::packaged_task<Result<T>(std::stop_token)> task(
        [this, work = std::move(work)](const std::stop_token& stop) {
          return work([&](double fraction) {
            progress_.store(fraction, std::memory_order_relaxed);
            return !stop.stop_requested();
          });
        });
    future_ = task.get_future();
    thread_ = std::jthread(std::move(task));
  }
  /// Cancels the work and waits until it has ended.
  ~InBackground() = default;
  InBackground(const InBackground&) = delete;
  InBackground& operator=(const InBackground&) = delete;

  /// The fraction that the work reported last, [0, 1].
  [[nodiscard]] double progress() const { return progress_.load(std::memory_order_relaxed); }
  /// Makes the work end with kCancelled when it next reports its progress, some milliseconds later;
  /// it never gives half a result. Has no effect after the work has ended.
  void cancel() { thread_.request_stop(); }
  /// Null until the work has ended. An exception of the work is thrown here, once.
  const Result<T>* poll() {
    if (!result_ && future_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
      return nullptr;
    }
    return &wait();
  }
  /// Blocks until the work has ended.
  const Result<T>& wait() {
    if (!result_) result_.emplace(future_.get());
    return *result_;
  }

 private:
  std::atomic<double> progress_{0};
  std::future<Result<T>> future_;
  std::optional<Result<T>> result_;
  // Last member, so that it is destroyed first, which waits for the end of the thread.
  std::jthread thread_;
};

}  // namespace nav::registration
