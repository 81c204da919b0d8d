// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "nav/source.hpp"

namespace nav::session {

/// A virtual source, such as a recording or a simulation, as a device: its samples come at their
/// own pace on a real clock. A thread of its own reads them ahead, so that an image that takes long
/// to simulate does not hold up the poses behind it. The first sample arrives when the first ones
/// have been read; all times of the samples move along. A sample that is read too late arrives
/// late, as it would from a device.
class PacedSource final : public Source {
 public:
  /// \p source never waits. \p clock advances with real time and must outlive this.
  PacedSource(std::shared_ptr<Source> source, const Clock& clock)
      : source_(std::move(source)), clock_(clock) {}
  ~PacedSource() override { stop(); }

  [[nodiscard]] const std::vector<StreamInfo>& streams() const override {
    return source_->streams();
  }
  Result<Sample> next(Deadline deadline) override;
  /// Also ends the reading ahead.
  void stop() noexcept override;
  [[nodiscard]] SourceHealth health() const override;

 private:
  void read_ahead();

  std::shared_ptr<Source> source_;
  const Clock& clock_;
  std::optional<Duration> shift_;  ///< Clock minus times of the source.
  mutable std::mutex mutex_;       ///< Guards the rest but the thread.
  std::condition_variable wake_;
  std::deque<Sample> ahead_;
  std::optional<Error> end_;  ///< The source's last word.
  bool stopped_ = false;
  SourceHealth health_;
  std::jthread thread_;
};

}  // namespace nav::session
