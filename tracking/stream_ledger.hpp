// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "nav/result.hpp"

namespace nav::tracking {

/// Accounts for every sample of a stream: received = delivered + superseded + rejected (by cause) +
/// dropped (by cause) + waiting, at every moment. Not thread-safe.
class StreamLedger {
 public:
  void receive() { ++received_; }
  /// Counts an image that was shown, or a pose that was taken into its buffer.
  void deliver() { ++delivered_; }
  /// Counts a sample that was replaced by a newer one before it was used.
  void supersede() { ++superseded_; }
  /// Counts a sample that was judged unusable.
  void reject(const std::string& cause) { ++rejected_[cause]; }
  /// Counts a sample that was lost because there was no room or no consumer.
  void drop(const std::string& cause) { ++dropped_[cause]; }
  /// The counts of this part of a stream and of the part that takes over what this one delivered.
  /// Precondition: \p next has received exactly that, otherwise a Bug.
  [[nodiscard]] StreamLedger followed_by(const StreamLedger& next) const;

  [[nodiscard]] std::uint64_t received() const { return received_; }
  [[nodiscard]] std::uint64_t delivered() const { return delivered_; }
  [[nodiscard]] std::uint64_t superseded() const { return superseded_; }
  [[nodiscard]] const std::map<std::string, std::uint64_t>& rejected() const { return rejected_; }
  [[nodiscard]] std::uint64_t rejected_total() const;
  [[nodiscard]] const std::map<std::string, std::uint64_t>& dropped() const { return dropped_; }
  [[nodiscard]] std::uint64_t dropped_total() const;
  /// Samples received but not yet accounted for. Precondition: never negative, otherwise a Bug.
  [[nodiscard]] std::uint64_t waiting() const;
  /// True when every sample is accounted for. A session checks this when it ends.
  [[nodiscard]] bool balanced() const { return waiting() == 0; }

 private:
  std::uint64_t received_ = 0;
  std::uint64_t delivered_ = 0;
  std::uint64_t superseded_ = 0;
  std::map<std::string, std::uint64_t> rejected_, dropped_;
};

}  // namespace nav::tracking
