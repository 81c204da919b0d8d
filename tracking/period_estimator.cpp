// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/period_estimator.hpp"

#include <algorithm>

namespace nav::tracking {

void PeriodEstimator::add(Timestamp stamp) {
  if (newest_ && stamp <= *newest_) return;
  if (newest_) {
    gaps_[count_++ % gaps_.size()] = stamp - *newest_;
    auto sorted = gaps_;
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(std::min(count_, gaps_.size()));
    const auto middle = sorted.begin() + (end - sorted.begin()) / 2;
    std::nth_element(sorted.begin(), middle, end);
    period_ = std::clamp<Duration>(*middle, std::chrono::milliseconds(1), std::chrono::seconds(10));
  }
  newest_ = stamp;
}

}  // namespace nav::tracking
