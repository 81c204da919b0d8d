// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "nav/time.hpp"

namespace nav::tracking {

/// Learns the period of a stream from its stamps: the median of the newest 64 gaps, limited to 1 ms
/// to 10 s. It starts unknown and never looks ahead. Not thread-safe.
class PeriodEstimator {
 public:
  /// Stamps that do not increase are passed over.
  void add(Timestamp stamp);
  /// Absent before the second stamp.
  [[nodiscard]] std::optional<Duration> period() const { return period_; }

 private:
  std::array<Duration, 64> gaps_{};
  std::size_t count_ = 0;  ///< Gaps so far; the newest overwrite the oldest.
  std::optional<Timestamp> newest_;
  std::optional<Duration> period_;
};

}  // namespace nav::tracking
