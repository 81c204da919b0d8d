// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/driver.hpp"

#include <algorithm>
#include <utility>

namespace nav::session {

Driver::Driver(Session& session, const RefreshRule& rule, Session::Listener listener)
    : session_(session), rule_(rule) {
  NAV_CHECK(rule.every >= 1 && (!rule.period || *rule.period > Duration(0)), rule.every);
  listener_.missing = std::move(listener.missing);
  listener_.pressed = std::move(listener.pressed);
  listener_.settled = [this,
                       settled = std::move(listener.settled)](const tracking::PairedImage& paired) {
    if (settled) settled(paired);
    if (paired.tracked && paired_++ % rule_.every == 0) due_ = true;
  };
}

/// True when a refresh is due; false at the limit and at the end.
Result<bool> Driver::advance(std::optional<Timestamp> until, bool ends) {
  if (finished_) {
    over_ = true;
    return false;
  }
  if (rule_.period) {
    if (until && session_.now() >= *until) return false;
    Timestamp next = session_.now() + *rule_.period;
    if (until) next = std::min(next, *until);
    if (auto ok = session_.advance_to(next, listener_); !ok) return ok.error();
    const bool at_end = session_.ended() && !until;
    if (at_end || (ends && until && next == *until)) session_.finish(listener_);
    finished_ = at_end;
    return true;
  }
  for (due_ = false; !due_;) {
    const auto next = session_.next_arrival();
    if (!next) return next.error();
    if (!*next) {
      session_.finish(listener_);
      finished_ = true;
      over_ = !due_;
      return due_;
    }
    if (until && **next > *until) return false;
    if (auto ok = session_.advance_to(**next, listener_); !ok) return ok.error();
  }
  return true;
}

Result<std::optional<Epoch>> Driver::next(std::optional<Timestamp> until, bool ends) {
  const auto due = advance(until, ends);
  if (!due) return due.error();
  if (!*due) return std::optional<Epoch>();
  return std::optional(session_.refresh());
}

Result<void> Driver::pass(Timestamp until) {
  while (session_.now() < until) {
    const Duration step = rule_.period.value_or(until - session_.now());
    const Timestamp next = std::min(session_.now() + step, until);
    if (auto ok = session_.advance_to(next, listener_); !ok) return ok;
  }
  return {};
}

Result<std::optional<Epoch>> Driver::next_at_pace(Timestamp clock_now, bool every_one) {
  constexpr auto kLate = std::chrono::milliseconds(100);
  // Longer, and a window would not answer the mouse.
  constexpr auto kMostWork = std::chrono::milliseconds(50);
  if (session_.live()) return next_live();
  const MonotonicClock since;
  while (!over_) {
    if (!waiting_) {
      const auto due = advance(std::nullopt, false);
      if (!due) return due.error();
      waiting_ = *due;
      if (!*due) break;
      if (!origin_) restart_pace(clock_now);
    }
    const Duration early = *origin_ + session_.now().time_since_epoch() - clock_now;
    if (early > Duration(0)) break;
    waiting_ = false;
    if (every_one || early >= -kLate || since.now() > Timestamp(kMostWork)) {
      return std::optional(session_.refresh());
    }
  }
  return std::optional<Epoch>();
}

std::optional<Epoch> Driver::next_live() {
  constexpr auto kLookAgain = std::chrono::milliseconds(100);
  due_ = false;
  over_ = session_.ended();
  session_.take_in(listener_);
  if (over_) session_.finish(listener_);
  const Timestamp now = session_.now();
  const bool look = !over_ && (!refreshed_at_ || now - *refreshed_at_ >= kLookAgain);
  if (!due_ && !look) return std::nullopt;
  refreshed_at_ = now;
  Epoch epoch = session_.refresh();
  std::vector<Safety> states{epoch.ultrasound, epoch.placement, epoch.needle};
  const bool same = std::ranges::equal(states, told_, [](const Safety& a, const Safety& b) {
    return a.state == b.state && a.cause == b.cause;
  });
  if (!due_ && same) return std::nullopt;
  told_ = std::move(states);
  return epoch;
}

void Driver::restart_pace(Timestamp clock_now) {
  origin_ = clock_now - session_.now().time_since_epoch();
}

Timestamp Driver::on_clock(Timestamp session_time) const {
  if (session_.live() || !origin_) return session_time;
  return *origin_ + session_time.time_since_epoch();
}

Epoch Driver::aged(Epoch epoch, Timestamp clock_now) const {
  if (session_.live()) return session_.navigator().aged(std::move(epoch), session_.now());
  if (!origin_) return epoch;
  return session_.navigator().aged(std::move(epoch), clock_now - origin_->time_since_epoch());
}

}  // namespace nav::session
