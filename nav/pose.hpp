// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "nav/time.hpp"
#include "nav/transform.hpp"

namespace nav {

/// Status that the tracker reports with a pose. kUnknown (no status received) is never treated as
/// kOk: the pose is degraded.
enum class TrackingStatus { kOk, kUnknown, kOccluded, kOutOfVolume, kTimeout, kInvalid };

/// Stable lower-case name, for reports.
const char* to_string(TrackingStatus status);

/// Pose as received from outside: 16 unchecked numbers.
struct RawPose {
  Timestamp acquired;
  Timestamp received;
  TrackingStatus status = TrackingStatus::kUnknown;
  Eigen::Matrix4d tracker_from_body = Eigen::Matrix4d::Constant(std::nan(""));
  bool clock_unsure = false;  ///< The clock of its device is not known well yet.
};

/// Why an admitted pose is not to be relied on: it is degraded.
enum class PoseDoubt {
  kNone,
  kNoStatus,  ///< The tracker gave no status.
  kClock,     ///< The times of the tracker are off the session clock.
  kStuck,     ///< The pose does not change to the last digit.
  kMoved,     ///< The body is the patient's reference, and was moved.
  kOnly,      ///< No other pose of the body has confirmed it yet.
};
/// One sentence about a body, such as "the probe"; empty for kNone.
std::string sentence(PoseDoubt doubt, const std::string& body);

/// Pose that passed the gate; without a transform: there was no valid pose at that time.
template <class Body>
struct TrackedPose {
  Timestamp acquired;
  TrackingStatus status;
  std::optional<Transform<frames::Tracker, Body>> tracker_from_body;
  PoseDoubt doubt = PoseDoubt::kNone;
};

}  // namespace nav
