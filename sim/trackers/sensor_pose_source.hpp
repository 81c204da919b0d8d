// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "sim/streams.hpp"
#include "sim/trackers/tracker_sensor.hpp"

namespace nav::sim {

/// Clock and transmission of a tracker.
struct TrackerTiming {
  double rate_hz = 50;                               ///< (0, 10 000].
  Duration latency = std::chrono::milliseconds(15);  ///< Time from measurement to reception, >= 0.
  Duration jitter = std::chrono::milliseconds(2);    ///< Added latency, uniform in [0, jitter].
  Duration clock_offset{0};                          ///< Device stamp minus session time.
  double drift_ppm = 0;                              ///< Drift of the device's clock, within 1e4.
  Duration stamp_step{0};  ///< Stamps are rounded to multiples of it; 0: not rounded.
  /// Losses in bursts, a two-state chain (Gilbert 1960, Elliott 1963): probability that a burst
  /// begins at a sample, and that it ends at one.
  double loss_begins = 0;
  double loss_ends = 0.2;  ///< (0, 1].
};

/// Rejects an invalid timing; the message names the first value out of range.
Result<void> validate(const TrackerTiming& timing);

/// Input of the simulation of one body's poses.
struct SensorStream {
  std::function<Eigen::Matrix4d(Timestamp)> truth;  ///< tracker_from_body, rigid, at any time.
  std::shared_ptr<const TrackerSensor> sensor;      ///< Not null.
  TrackerTiming timing;
  Timestamp begin, end;  ///< Time of the first measurement; no measurement after end.
  std::uint64_t body = 0;
  std::uint64_t seed = 1;  ///< Seed of jitter and losses.
};

/// Poses of one body as measured by a tracker, on the virtual clock. Lost samples have kOccluded
/// and NaN, never an old pose or identity. Not thread-safe.
class SensorPoseSource final : public PoseStream {
 public:
  /// Precondition: validate(timing), otherwise a Bug.
  explicit SensorPoseSource(const SensorStream& stream);
  Result<RawPose> next(Deadline deadline) override;
  void stop() noexcept override { stopped_ = true; }
  /// Arrival of the next pose; Timestamp::max() after the last.
  [[nodiscard]] Timestamp next_arrival() const;

 private:
  std::vector<RawPose> poses_;  ///< Poses in order of arrival.
  std::size_t position_ = 0;
  bool stopped_ = false;
};

}  // namespace nav::sim
