// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "nav/pose.hpp"

namespace nav::sim {

/// Measurement of one true pose.
struct Observation {
  TrackingStatus status = TrackingStatus::kInvalid;
  /// tracker_from_body, mm; NaN unless the status is kOk.
  Eigen::Matrix4d pose = Eigen::Matrix4d::Constant(std::nan(""));
};

/// Measuring part of a tracker, without its clock. Tracker frame: origin at the device, +z into the
/// measurement volume, mm. The result depends only on the arguments; thread-safe.
class TrackerSensor {
 public:
  virtual ~TrackerSensor() = default;
  /// \p truth: rigid tracker_from_body. \p body: number of the tracked body, which selects its
  /// noise. \p sample: index of the measurement of that body.
  [[nodiscard]] virtual Observation observe(const Eigen::Matrix4d& truth, std::uint64_t body,
                                            std::uint64_t sample) const = 0;
  [[nodiscard]] virtual const char* name() const = 0;
};

}  // namespace nav::sim
