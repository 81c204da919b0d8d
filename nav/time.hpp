// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

namespace nav {

/// The only clock of a session: int64 nanoseconds from an arbitrary origin. It is virtual in replay
/// and tests, and monotonic when live. It has no now(): time is an argument or comes from a Clock.
struct SessionClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = std::chrono::duration<rep, period>;
  using time_point = std::chrono::time_point<SessionClock>;
  static constexpr bool is_steady = true;
};

using Timestamp = SessionClock::time_point;
using Duration = SessionClock::duration;
/// Time at which a call must have returned.
using Deadline = Timestamp;

/// Converts seconds (from reports and file formats) to a session duration, rounded to the nearest
/// nanosecond. Precondition: finite and |seconds| < 4.6e9, otherwise a Bug.
Duration from_seconds(double seconds);
/// Converts a session duration to seconds.
double to_seconds(Duration duration);
/// Seconds since the origin of the session clock.
inline double to_seconds(Timestamp time) { return to_seconds(time.time_since_epoch()); }
/// True when from_seconds() accepts the value.
bool is_representable_seconds(double seconds);

/// Source of the current session time. Implementations are thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual Timestamp now() const = 0;
};

/// Real time from CLOCK_MONOTONIC; its origin is the construction. Changes of the wall clock do not
/// affect it.
class MonotonicClock final : public Clock {
 public:
  MonotonicClock();
  [[nodiscard]] Timestamp now() const override;

 private:
  std::chrono::steady_clock::time_point origin_;
};

/// Time that advances only by advance_to(). Not thread-safe: replay and tests use it on one thread.
class VirtualClock final : public Clock {
 public:
  [[nodiscard]] Timestamp now() const override { return now_; }
  /// Advances to a time that is not before now(), otherwise a Bug.
  void advance_to(Timestamp time);

 private:
  Timestamp now_{};
};

}  // namespace nav
