// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "session/session.hpp"

namespace nav::session {

/// When a display is refreshed.
struct RefreshRule {
  std::optional<Duration> period = std::nullopt;  ///< Fixed, on the session clock, > 0.
  std::int64_t every = 1;  ///< Without a period: with every n-th paired image, >= 1.
};

/// The one loop of every session: advances it from refresh to refresh. Not thread-safe.
class Driver {
 public:
  /// \p session must outlive the driver.
  Driver(Session& session, const RefreshRule& rule, Session::Listener listener = {});

  /// Virtual: advances to the next refresh, at most to \p until. Absent when none is due by then,
  /// and when the sources have ended. \p ends: nothing after \p until counts, so that images which
  /// wait then are settled before the last refresh.
  Result<std::optional<Epoch>> next(std::optional<Timestamp> until = {}, bool ends = false);
  /// Advances to a time without any refresh: nobody looks.
  Result<void> pass(Timestamp until);

  /// A virtual session at the pace of a clock: the next refresh once its time has come, counted
  /// from the first refresh. Absent while none is due, and when over(). Refreshes that are late by
  /// more than 100 ms are left out, unless \p every_one. A live session: its newest epoch when an
  /// image came or, looked at ten times a second, when a state or its cause has changed; the first
  /// call gives the epoch before the first image.
  Result<std::optional<Epoch>> next_at_pace(Timestamp clock_now, bool every_one);
  /// The clock's time of the session's present is this: for a session that took long to show its
  /// first epoch.
  void restart_pace(Timestamp clock_now);
  /// An epoch that is still shown, as old as it is by now.
  [[nodiscard]] Epoch aged(Epoch epoch, Timestamp clock_now) const;
  /// The clock's time of a session time: itself for a live session, and by the pace of
  /// next_at_pace() for a virtual one.
  [[nodiscard]] Timestamp on_clock(Timestamp session_time) const;
  /// A refresh is due that next_at_pace() has not given yet.
  [[nodiscard]] bool waiting() const { return waiting_; }
  /// The sources have ended, and so has everything that waited.
  [[nodiscard]] bool over() const { return over_; }

 private:
  Result<bool> advance(std::optional<Timestamp> until, bool ends);
  std::optional<Epoch> next_live();

  Session& session_;
  RefreshRule rule_;
  Session::Listener listener_;
  std::int64_t paired_ = 0;
  bool due_ = false;
  bool waiting_ = false;
  bool finished_ = false;  ///< The sources have ended; a last refresh may be due.
  bool over_ = false;
  std::vector<Safety> told_;               ///< Live: states of the newest epoch.
  std::optional<Timestamp> refreshed_at_;  ///< Live: time of the newest refresh.
  std::optional<Timestamp> origin_;        ///< Session time 0 on the clock of next_at_pace().
};

}  // namespace nav::session
