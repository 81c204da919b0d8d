// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "nav/result.hpp"

namespace nav::tracking {

/// Accounts for every received image: received = shown + superseded + rejected (by cause) + waiting
/// for a pose. Not thread-safe.
class FrameLedger {
 public:
  void receive() { ++received_; }
  void show() { ++shown_; }
  /// Counts an image that was replaced by a newer one before it was shown.
  void supersede() { ++superseded_; }
  void reject(const std::string& cause) { ++rejected_[cause]; }

  [[nodiscard]] std::uint64_t received() const { return received_; }
  [[nodiscard]] std::uint64_t shown() const { return shown_; }
  [[nodiscard]] std::uint64_t superseded() const { return superseded_; }
  [[nodiscard]] const std::map<std::string, std::uint64_t>& rejected() const { return rejected_; }
  [[nodiscard]] std::uint64_t rejected_total() const;
  /// Images received but not yet accounted for. Precondition: never negative, otherwise a Bug.
  [[nodiscard]] std::uint64_t waiting() const;
  /// True when every image is accounted for. A session checks this when it ends.
  [[nodiscard]] bool balanced() const { return waiting() == 0; }

 private:
  std::uint64_t received_ = 0;
  std::uint64_t shown_ = 0;
  std::uint64_t superseded_ = 0;
  std::map<std::string, std::uint64_t> rejected_;
};

}  // namespace nav::tracking
