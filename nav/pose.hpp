// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "nav/time.hpp"
#include "nav/transform.hpp"

namespace nav {

/// What the tracker said of a pose. "Unknown" (no status came) is never "ok": it degrades.
enum class TrackingStatus { kOk, kUnknown, kOccluded, kOutOfVolume, kTimeout, kInvalid };

/// Stable lower-case name, for reports.
const char* to_string(TrackingStatus status);

/// A pose as it came from outside: 16 numbers that nobody has judged yet.
struct RawPose {
  Timestamp acquired;
  Timestamp received;
  TrackingStatus status = TrackingStatus::kUnknown;
  Eigen::Matrix4d tracker_from_body = Eigen::Matrix4d::Constant(std::nan(""));
};

/// A pose that passed the gate, or the fact that there was none.
template <class Body>
struct TrackedPose {
  Timestamp acquired;
  TrackingStatus status;
  std::optional<Transform<frames::Tracker, Body>> tracker_from_body;
};

}  // namespace nav
