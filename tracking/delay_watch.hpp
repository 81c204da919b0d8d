// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "nav/check.hpp"
#include "nav/time.hpp"

namespace nav::tracking {

/// Detects that a device's clock was set. A wrong clock cannot hide one thing: the delay from
/// acquisition to reception is nearly constant. A delayed stream looks the same, and its samples
/// are rejected too, because they are no longer live. When the delayed samples arrive all at once,
/// a false stamp may seem to have the usual age. Therefore, after a late sample, samples are
/// accepted again only after they have arrived in time for kProbation. The usual delay is the
/// median of the first samples and then stays fixed, so that a drifting clock is detected too. Not
/// thread-safe.
class DelayWatch {
 public:
  /// \p tolerance: largest accepted difference from the usual delay, > 0.
  explicit DelayWatch(Duration tolerance) : tolerance_(tolerance) {
    NAV_CHECK(tolerance > Duration::zero(), tolerance.count());
  }

  /// True when the time stamp of a sample is plausible. Call it once for each sample, in order of
  /// reception.
  bool believes(Timestamp acquired, Timestamp received) {
    const Duration delay = received - acquired;
    if (count_ < delays_.size()) {
      const auto end = delays_.begin() + static_cast<std::ptrdiff_t>(count_++);
      // The delays are kept sorted, so that the median is available at once.
      const auto place = std::upper_bound(delays_.begin(), end, delay);
      std::move_backward(place, end, end + 1);
      *place = delay;
    }
    return judge(delay - delays_[(count_ - 1) / 2], received);
  }

  /// Usual delay so far. Precondition: at least one sample.
  [[nodiscard]] Duration usual() const {
    NAV_CHECK(count_ > 0);
    return delays_[(count_ - 1) / 2];
  }

 private:
  static constexpr Duration kProbation = std::chrono::milliseconds(100);

  bool judge(Duration excess, Timestamp received) {
    if (excess > tolerance_) held_up_ = true;
    if (excess > tolerance_ || excess < -tolerance_) {
      in_time_since_.reset();
      return false;
    }
    if (!held_up_) return true;
    if (!in_time_since_) in_time_since_ = received;
    held_up_ = received - *in_time_since_ < kProbation;
    return !held_up_;
  }

  Duration tolerance_;
  std::array<Duration, 9> delays_{};
  std::size_t count_ = 0;
  bool held_up_ = false;
  std::optional<Timestamp> in_time_since_;
};

}  // namespace nav::tracking
