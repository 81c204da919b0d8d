// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "nav/pose.hpp"

namespace nav::sim {

/// What a tracker makes of one true pose.
struct Observation {
  TrackingStatus status = TrackingStatus::kInvalid;
  /// tracker_from_body, mm; NaN unless the status is kOk.
  Eigen::Matrix4d pose = Eigen::Matrix4d::Constant(std::nan(""));
};

/// The measuring part of a tracker, without its clock. Tracker frame: origin at the device, +z into
/// the measurement volume, mm. Same arguments, same answer; thread-safe.
class TrackerSensor {
 public:
  virtual ~TrackerSensor() = default;
  /// truth: a rigid tracker_from_body. body: number of the tracked body, tells noise apart.
  /// sample: counts the measurements of one body.
  [[nodiscard]] virtual Observation observe(const Eigen::Matrix4d& truth, std::uint64_t body,
                                            std::uint64_t sample) const = 0;
  [[nodiscard]] virtual const char* name() const = 0;
};

}  // namespace nav::sim
