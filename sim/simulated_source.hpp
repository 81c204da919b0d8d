// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "nav/source.hpp"
#include "sim/session/simulated_session.hpp"
#include "sim/streams.hpp"

namespace nav::sim {

/// The streams of a simulation as one source, in order of arrival. Samples that arrive at the same
/// time come in the order of the streams. Not thread-safe but for stop().
class SimulatedSource final : public Source {
 public:
  /// \p wait returns when the session clock has reached a time, or earlier after stop(): sleep on a
  /// live clock. Without it the source is virtual and never waits.
  explicit SimulatedSource(std::function<void(Timestamp)> wait = {}) : wait_(std::move(wait)) {}

  void add(const std::string& tool, ToolRole role, std::unique_ptr<PoseStream> poses);
  void add(const std::string& name, std::unique_ptr<ImageStream> images);
  /// A button with its changes, at rising times; each arrives at once.
  void add(const std::string& name, ButtonAction action, std::vector<ButtonSample> changes);

  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }
  Result<Sample> next(Deadline deadline) override;
  void stop() noexcept override { stopped_ = true; }

 private:
  struct Feed {
    std::unique_ptr<PoseStream> poses;
    std::unique_ptr<ImageStream> images;
    std::vector<ButtonSample> changes;  ///< Without poses and images.
    std::optional<Sample> head;
    std::uint64_t count = 0;
    bool ended = false;
  };
  Result<void> fill_head(std::size_t stream);

  std::function<void(Timestamp)> wait_;
  std::vector<StreamInfo> streams_;
  std::vector<Feed> feeds_;
  std::atomic<bool> stopped_{false};
};

/// Probe, reference, needle (if there is one: the poses of its straight tip, from its hub) and
/// images of a simulated session, without faults. The session must outlive the source.
std::unique_ptr<SimulatedSource> source_of(const SimulatedSession& session,
                                           std::function<void(Timestamp)> wait = {});

}  // namespace nav::sim
