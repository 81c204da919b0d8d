// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/time.hpp"

#include <cmath>

#include "nav/check.hpp"

namespace nav {
namespace {
// int64 nanoseconds end at 9.22e9 s. Within this limit, the difference of any two times is
// representable.
constexpr double kMaxSeconds = 4.6e9;
}  // namespace

bool is_representable_seconds(double seconds) {
  return std::isfinite(seconds) && std::abs(seconds) < kMaxSeconds;
}

Duration from_seconds(double seconds) {
  NAV_CHECK(is_representable_seconds(seconds), seconds);
  // Whole seconds and the fraction are converted separately: a double holds an epoch of 1.7e9 s
  // only to 0.2 µs.
  const double whole = std::floor(seconds);
  const double fraction = seconds - whole;
  return std::chrono::seconds(static_cast<std::int64_t>(whole)) +
         Duration(static_cast<std::int64_t>(std::llround(fraction * 1e9)));
}

double to_seconds(Duration duration) { return static_cast<double>(duration.count()) * 1e-9; }

MonotonicClock::MonotonicClock() : origin_(std::chrono::steady_clock::now()) {}

Timestamp MonotonicClock::now() const {
  return Timestamp(
      std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now() - origin_));
}

void VirtualClock::advance_to(Timestamp time) {
  NAV_CHECK(time >= now_, to_seconds(time), to_seconds(now_));
  now_ = time;
}

}  // namespace nav
