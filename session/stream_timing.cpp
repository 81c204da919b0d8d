// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/stream_timing.hpp"

#include <algorithm>
#include <vector>

namespace nav::session {

void StreamTiming::add(Timestamp received, std::uint64_t sequence) {
  if (newest_) {
    const double period_ms = 1e3 * to_seconds(received - *newest_);
    periods_ms_[(count_ - 1) % kKept] = static_cast<float>(period_ms);
    longest_ms_ = std::max(longest_ms_, period_ms);
    if (sequence > newest_sequence_ + 1) missing_ += sequence - newest_sequence_ - 1;
  } else {
    first_ = received;
  }
  newest_ = received;
  newest_sequence_ = sequence;
  ++count_;
}

StreamTiming::Summary StreamTiming::summary() const {
  Summary found;
  found.missing = missing_;
  found.period_max_ms = longest_ms_;
  if (count_ < 2) return found;
  const double seconds = to_seconds(*newest_ - *first_);
  if (seconds > 0) found.rate_hz = static_cast<double>(count_ - 1) / seconds;
  const std::size_t kept = std::min<std::uint64_t>(count_ - 1, kKept);
  std::vector<float> sorted(periods_ms_.begin(),
                            periods_ms_.begin() + static_cast<std::ptrdiff_t>(kept));
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&](double share) {
    return static_cast<double>(
        sorted[static_cast<std::size_t>(share * static_cast<double>(kept - 1) + 0.5)]);
  };
  found.period_p50_ms = at(0.5);
  found.period_p95_ms = at(0.95);
  found.period_p99_ms = at(0.99);
  return found;
}

}  // namespace nav::session
