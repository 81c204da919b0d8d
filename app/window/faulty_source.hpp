// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>

#include "nav/source.hpp"

namespace nav::app {

/// A simulated device whose faults are switched on for a time, for training and tests: markers that
/// the tracker does not see, and images that do not arrive.
class FaultySource final : public Source {
 public:
  /// The clock must outlive it.
  FaultySource(std::shared_ptr<Source> source, const Clock& clock)
      : source_(std::move(source)), clock_(clock) {}

  /// Thread-safe, both.
  void cover_marker(Duration time) { covered_until_ = (clock_.now() + time).time_since_epoch(); }
  void hold_images(Duration time) { held_until_ = (clock_.now() + time).time_since_epoch(); }

  [[nodiscard]] const std::vector<StreamInfo>& streams() const override {
    return source_->streams();
  }
  Result<Sample> next(Deadline deadline) override;
  void stop() noexcept override { source_->stop(); }
  [[nodiscard]] SourceHealth health() const override { return source_->health(); }

 private:
  [[nodiscard]] bool holds(const std::atomic<Duration>& until) const {
    return clock_.now().time_since_epoch() < until.load();
  }

  std::shared_ptr<Source> source_;
  const Clock& clock_;
  std::atomic<Duration> covered_until_{Duration(0)};
  std::atomic<Duration> held_until_{Duration(0)};
};

}  // namespace nav::app
