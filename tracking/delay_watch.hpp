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

/// Tells when a clock has been set, from the one thing that a wrong clock cannot hide: the way from
/// acquisition to reception takes about as long as it always did. A stream that was held up looks
/// the same, and is refused as well: it is no longer live. While what was held up arrives all at
/// once, a false stamp may look as old as it should; so after a late sample, samples are believed
/// again only when they have come in time for kProbation. The usual delay is the median of the
/// first samples and then stays, so that a drifting clock is noticed too. Not thread-safe.
class DelayWatch {
 public:
  /// tolerance > 0: how far a delay may be from the usual one.
  explicit DelayWatch(Duration tolerance) : tolerance_(tolerance) {
    NAV_CHECK(tolerance > Duration::zero(), tolerance.count());
  }

  /// Whether a sample's stamp is believed. Ask once for each sample, in order of reception.
  bool believes(Timestamp acquired, Timestamp received) {
    const Duration delay = received - acquired;
    if (count_ < delays_.size()) {
      const auto end = delays_.begin() + static_cast<std::ptrdiff_t>(count_++);
      // Kept sorted, so that the median is at hand.
      const auto place = std::upper_bound(delays_.begin(), end, delay);
      std::move_backward(place, end, end + 1);
      *place = delay;
    }
    return judge(delay - delays_[(count_ - 1) / 2], received);
  }

  /// The usual delay so far. Precondition: at least one sample.
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
