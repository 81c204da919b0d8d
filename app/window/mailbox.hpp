// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

#include "nav/time.hpp"

namespace nav::app {

/// Hands over the newest value from one thread to another. What a newer value replaces is counted
/// as superseded. Thread-safe.
template <class T>
class Mailbox {
 public:
  /// True if the box was empty: the taker has to be told.
  bool put(T value) {
    const std::lock_guard lock(mutex_);
    const bool was_empty = !value_;
    if (!was_empty) ++superseded_;
    value_ = std::move(value);
    filled_.notify_one();
    return was_empty;
  }
  /// Absent: nothing has come since the last call.
  std::optional<T> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(value_, std::nullopt);
  }
  /// Waits for a value, at most for a time. Absent: none came, or the box was closed.
  std::optional<T> wait(Duration most) {
    std::unique_lock lock(mutex_);
    filled_.wait_for(lock, most, [this] { return value_.has_value() || closed_; });
    return std::exchange(value_, std::nullopt);
  }
  /// Calls look with the value that waits, if there is one. It must be short: put() waits for it.
  template <class Look>
  void peek(const Look& look) const {
    const std::lock_guard lock(mutex_);
    if (value_) look(*value_);
  }
  /// Ends waiting for good.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    filled_.notify_all();
  }
  [[nodiscard]] bool closed() const {
    const std::lock_guard lock(mutex_);
    return closed_;
  }
  [[nodiscard]] std::uint64_t superseded() const {
    const std::lock_guard lock(mutex_);
    return superseded_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::optional<T> value_;
  bool closed_ = false;
  std::uint64_t superseded_ = 0;
};

}  // namespace nav::app
