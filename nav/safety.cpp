// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/safety.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "nav/check.hpp"

namespace nav {

const char* to_string(SafetyState state) {
  switch (state) {
    case SafetyState::kValid:
      return "valid";
    case SafetyState::kDegraded:
      return "degraded";
    case SafetyState::kStale:
      return "stale";
    case SafetyState::kLost:
      return "lost";
  }
  return "unknown";
}

Safety compose(const std::vector<Safety>& inputs) {
  NAV_CHECK(!inputs.empty());
  return *std::max_element(inputs.begin(), inputs.end(), [](const Safety& a, const Safety& b) {
    return static_cast<int>(a.state) < static_cast<int>(b.state);
  });
}

FreshnessLimits freshness_limits(Duration period) {
  NAV_CHECK(period > Duration::zero(), period.count());
  using std::chrono::milliseconds;
  const Duration stale = std::max<Duration>(2 * period, period + milliseconds(20));
  return {stale, std::max<Duration>(5 * stale, milliseconds(250))};
}

Safety freshness(std::string_view input, Timestamp acquired, Timestamp now,
                 const FreshnessLimits& limits) {
  const Duration age = now - acquired;
  std::ostringstream text;
  const auto ms = [](Duration d) { return std::lround(to_seconds(d) * 1e3); };
  if (age < Duration::zero()) {
    text << input << " is stamped " << ms(-age) << " ms in the future";
    return {SafetyState::kDegraded, text.str()};
  }
  if (age <= limits.stale_after) return {SafetyState::kValid, ""};
  const bool lost = age > limits.lost_after;
  text << input << " is " << ms(age) << " ms old, limit "
       << ms(lost ? limits.lost_after : limits.stale_after) << " ms";
  return {lost ? SafetyState::kLost : SafetyState::kStale, text.str()};
}

}  // namespace nav
