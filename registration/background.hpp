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

/// A registration on a thread of its own: whatever takes `progress` as register_sweep() does. All
/// of it is thread-safe, but wait() and poll(), which belong to one thread.
template <class T>
class InBackground {
 public:
  using Progress = std::function<bool(double fraction)>;
  using Work = std::function<Result<T>(const Progress& progress)>;

  /// Begins at once. What work refers to has to live until this is destroyed.
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
  /// Cancels and waits until the work has seen it.
  ~InBackground() = default;
  InBackground(const InBackground&) = delete;
  InBackground& operator=(const InBackground&) = delete;

  /// What the work said last, [0, 1].
  [[nodiscard]] double progress() const { return progress_.load(std::memory_order_relaxed); }
  /// The work ends with kCancelled the next time that it asks, some milliseconds; never a half
  /// result. Of no effect once it has ended.
  void cancel() { thread_.request_stop(); }
  /// Null until the work has ended. What the work threw is thrown here, once.
  const Result<T>* poll() {
    if (!result_ && future_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
      return nullptr;
    }
    return &wait();
  }
  /// Blocks.
  const Result<T>& wait() {
    if (!result_) result_.emplace(future_.get());
    return *result_;
  }

 private:
  std::atomic<double> progress_{0};
  std::future<Result<T>> future_;
  std::optional<Result<T>> result_;
  std::jthread thread_;  // Last: its end is waited for first.
};

}  // namespace nav::registration
