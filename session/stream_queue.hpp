// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <vector>

#include "nav/sample.hpp"
#include "session/stream_timing.hpp"
#include "tracking/stream_ledger.hpp"

namespace nav::session {

/// Behaviour of a queue whose consumer is slower than its source.
enum class QueuePolicy {
  kNewestOnly,  ///< Keeps one sample; an older one counts as superseded. For images on a display.
  kLossless,    ///< Keeps all samples up to the capacity; then counts the new one as dropped. For
                ///< poses and recordings.
};

/// Times of an image that a newer one superseded: they still tell about period and clock.
struct SupersededStamp {
  Timestamp received;
  std::optional<DeviceTime> device_time;
  std::optional<Timestamp> acquired;  ///< The device's own; absent for a missing image.
};

/// One stream between the thread of its source and the session. Thread-safe.
class StreamQueue {
 public:
  /// \p capacity: samples, >= 1.
  StreamQueue(QueuePolicy policy, std::size_t capacity);
  void push(Sample sample);
  /// Appends all waiting samples, in order of arrival. \p superseded: appends the times of those
  /// that were superseded since the last call, all of which came before the waiting ones.
  void drain(std::vector<Sample>& into, std::vector<SupersededStamp>& superseded);
  /// Counts of this queue: a sample that was drained counts as delivered.
  [[nodiscard]] tracking::StreamLedger ledger() const;
  /// Periods of all samples that were pushed.
  [[nodiscard]] StreamTiming::Summary timing() const;

 private:
  QueuePolicy policy_;
  std::size_t capacity_;
  mutable std::mutex mutex_;
  std::deque<Sample> samples_;
  tracking::StreamLedger ledger_;
  StreamTiming timing_;
  std::vector<SupersededStamp> superseded_;  ///< At most kMostStamps.
};

}  // namespace nav::session
