// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/reopened_source.hpp"

#include <utility>

namespace nav::devices {

ReopenedSource::ReopenedSource(std::string name, RetryTimes retry, const Clock& clock,
                               Diagnostics& diagnostics, const char* reporter)
    : PolledSource(clock, diagnostics, reporter),
      name_(std::move(name)),
      due_(clock.now()),
      retry_(retry) {}

SourceHealth ReopenedSource::health() const {
  const std::lock_guard lock(mutex_);
  SourceHealth health = health_;
  if (is_stopped()) health.state = SourceState::kEnded;
  return health;
}

void ReopenedSource::count(const char* cause, std::uint64_t times) {
  const std::lock_guard lock(mutex_);
  health_.bad_messages[cause] += times;
}

void ReopenedSource::count_bytes(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  health_.bytes += bytes;
}

void ReopenedSource::count_repeat() {
  const std::lock_guard lock(mutex_);
  ++health_.repeats;
}

void ReopenedSource::set_state(SourceState state) {
  state_ = state;
  const std::lock_guard lock(mutex_);
  health_.state = state;
}

void ReopenedSource::set_cause(const std::string& cause) {
  const std::lock_guard lock(mutex_);
  health_.cause = cause;
}

bool ReopenedSource::connected() {
  const bool was_lost = !std::exchange(reported_loss_, {}).empty();
  retry_.reset();
  const std::lock_guard lock(mutex_);
  health_.reconnects = connections_++;
  return was_lost;
}

void ReopenedSource::lose(const TcpFailure& failure) {
  const bool was_open = is_open();
  close();
  set_cause(failure.cause);
  if (was_open || reported_loss_ != failure.message) {
    reported_loss_ = failure.message;
    report(Severity::kWarning, failure.message + "; it is tried again");
  }
  if (was_open) forget_reports();
  set_state(SourceState::kWaiting);
  due_ = clock().now() + retry_.take();
}

}  // namespace nav::devices
