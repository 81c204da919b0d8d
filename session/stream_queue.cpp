// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/stream_queue.hpp"

#include <iterator>

#include "nav/check.hpp"

namespace nav::session {
namespace {

SupersededStamp stamp_of(const Sample& sample) {
  SupersededStamp stamp{
      .received = sample.received, .device_time = sample.device_time, .acquired = std::nullopt};
  if (const auto* image = std::get_if<UltrasoundImage>(&sample.what)) {
    stamp.acquired = image->acquired;
  }
  return stamp;
}

}  // namespace

StreamQueue::StreamQueue(QueuePolicy policy, std::size_t capacity)
    : policy_(policy), capacity_(policy == QueuePolicy::kNewestOnly ? 1 : capacity) {
  NAV_CHECK(capacity >= 1, capacity);
}

void StreamQueue::push(Sample sample) {
  const std::lock_guard lock(mutex_);
  ledger_.receive();
  timing_.add(sample.received, sample.sequence);
  if (samples_.size() >= capacity_) {
    if (policy_ == QueuePolicy::kLossless) {
      ledger_.drop("queue_full");
      return;
    }
    ledger_.supersede();
    constexpr std::size_t kMostStamps = 4096;
    if (superseded_.size() < kMostStamps) superseded_.push_back(stamp_of(samples_.front()));
    samples_.pop_front();
  }
  samples_.push_back(std::move(sample));
}

void StreamQueue::drain(std::vector<Sample>& into, std::vector<SupersededStamp>& superseded) {
  const std::lock_guard lock(mutex_);
  superseded.insert(superseded.end(), superseded_.begin(), superseded_.end());
  superseded_.clear();
  for (std::size_t i = 0; i < samples_.size(); ++i) ledger_.deliver();
  into.insert(into.end(), std::move_iterator(samples_.begin()), std::move_iterator(samples_.end()));
  samples_.clear();
}

tracking::StreamLedger StreamQueue::ledger() const {
  const std::lock_guard lock(mutex_);
  return ledger_;
}

StreamTiming::Summary StreamQueue::timing() const {
  const std::lock_guard lock(mutex_);
  return timing_.summary();
}

}  // namespace nav::session
