// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/paced_source.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace nav::session {
namespace {

/// Samples that are read ahead: at 50 poses per second of three bodies, about two seconds.
constexpr std::size_t kMostAhead = 384;
/// Time that is read ahead before the first sample arrives.
constexpr auto kLead = std::chrono::milliseconds(500);
/// A wait of this length is as good as one without an end, and no clock overflows.
constexpr auto kLongWait = std::chrono::hours(1);

}  // namespace

/// The root of the thread: nothing leaves it but samples and the last word.
void PacedSource::read_ahead() {
  std::optional<Error> end;
  while (!end) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stopped_ || ahead_.size() < kMostAhead; });
      if (stopped_) return;
    }
    std::optional<Sample> sample;
    try {
      auto read = source_->next(Timestamp::max());
      if (read) {
        sample = *std::move(read);
      } else {
        end = read.error();
      }
    } catch (const std::exception& error) {
      end = Error{ErrorCode::kUnavailable, std::string("internal error: ") + error.what()};
    }
    {
      const std::lock_guard lock(mutex_);
      if (sample) ahead_.push_back(*std::move(sample));
      end_ = end;
    }
    wake_.notify_all();
  }
}

Result<Sample> PacedSource::next(Deadline deadline) {
  const auto wait_until = [&](std::unique_lock<std::mutex>& lock, Timestamp time, auto ready) {
    const auto done = [&] { return stopped_ || ready(); };
    for (Timestamp now = clock_.now(); now < time && !done(); now = clock_.now()) {
      const bool far = time - kLongWait > now;
      wake_.wait_for(lock, far ? Duration(kLongWait) : time - now, done);
    }
  };
  std::unique_lock lock(mutex_);
  if (!thread_.joinable() && !stopped_) thread_ = std::jthread([this] { read_ahead(); });
  const auto ready = [&] {
    if (end_ || (shift_ && !ahead_.empty()) || ahead_.size() >= kMostAhead) return true;
    return !ahead_.empty() && ahead_.back().received - ahead_.front().received >= kLead;
  };
  wait_until(lock, deadline, ready);
  const auto stopped = [] { return Error{ErrorCode::kCancelled, "the device was stopped"}; };
  const auto timeout = [] { return Error{ErrorCode::kTimeout, "nothing more by the deadline"}; };
  if (stopped_) return stopped();
  if (!ready()) return timeout();
  if (ahead_.empty()) {
    health_.state = SourceState::kEnded;
    health_.cause = end_->message;
    return *end_;
  }
  if (!shift_) shift_ = clock_.now() - ahead_.front().received;
  const Timestamp arrives = ahead_.front().received + *shift_;
  wait_until(lock, std::min(arrives, deadline), [] { return false; });
  if (stopped_) return stopped();
  if (clock_.now() < arrives) return timeout();
  health_.state = SourceState::kStreaming;
  Sample sample = std::move(ahead_.front());
  ahead_.pop_front();
  lock.unlock();
  wake_.notify_all();
  sample.received = clock_.now();
  const auto move_along = [&](auto& timed) {
    timed.acquired += *shift_;
    timed.received = sample.received;
  };
  if (auto* image = std::get_if<UltrasoundImage>(&sample.what)) move_along(*image);
  if (auto* pose = std::get_if<PoseSample>(&sample.what)) move_along(pose->pose);
  if (auto* button = std::get_if<ButtonSample>(&sample.what)) button->acquired += *shift_;
  return sample;
}

void PacedSource::stop() noexcept {
  source_->stop();
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable() && thread_.get_id() != std::this_thread::get_id()) thread_.join();
}

SourceHealth PacedSource::health() const {
  const std::lock_guard lock(mutex_);
  return health_;
}

}  // namespace nav::session
