// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "nav/pose.hpp"
#include "tracking/delay_watch.hpp"

namespace nav::tracking {

/// Conditions that a pose must meet before it is used.
struct PoseGateOptions {
  RigidTolerance rigid;
  double working_radius_mm = 10000;  ///< Largest |translation| in the Tracker frame.
  double max_speed_mm_per_s = 5000;  ///< Speed between neighbouring admitted poses of one body.
  /// Rotation between neighbouring admitted poses less than a second apart, rad, in (0, pi]. A
  /// larger rotation means that markers were confused, not that a hand moved.
  double max_turn_rad = 1.2;
  /// Longest time by which a stamp may lie after its reception; beyond it the device's clock is
  /// wrong.
  Duration max_future = std::chrono::milliseconds(100);
  /// Largest accepted difference from the stream's usual delay between acquisition and reception, >
  /// 0. A larger one means that the device's clock was set or the stream was delayed.
  Duration max_delay_change = std::chrono::milliseconds(60);
};

/// Rejects limits that are NaN or not positive.
Result<void> validate(const PoseGateOptions& options);

/// Cause of a rejection. The names are stable, for the ledger and reports.
enum class PoseRejection { kStatus, kNotRigid, kOutsideVolume, kTime, kClock, kTooFast };
const char* to_string(PoseRejection cause);
/// True when the time of a rejected pose may be used: it tells that there was no valid pose then.
inline bool has_usable_time(const std::optional<PoseRejection>& cause) {
  return cause != PoseRejection::kTime && cause != PoseRejection::kClock;
}

/// Decision about one pose.
template <class Body>
struct Admission {
  TrackedPose<Body> pose;                  ///< Has a transform if and only if it was admitted.
  std::optional<PoseRejection> rejection;  ///< Absent when admitted.
  std::string message;                     ///< One sentence when rejected.
};

namespace detail {
/// Frame-independent part of the gate: the state of one body.
class GateState {
 public:
  explicit GateState(const PoseGateOptions& options)
      : options_(options), delay_(options.max_delay_change) {}
  struct Verdict {
    std::optional<PoseRejection> rejection;
    std::string message;
  };
  Verdict judge(const RawPose& raw, const std::string& name);

 private:
  [[nodiscard]] Verdict judge_time(const RawPose& raw, const std::string& name);
  [[nodiscard]] Verdict judge_motion(const RawPose& raw, const Eigen::Quaterniond& rotation,
                                     const std::string& name) const;

  PoseGateOptions options_;
  DelayWatch delay_;
  std::optional<Timestamp> newest_;  ///< Newest usable time, of admitted and rejected poses.
  std::optional<Timestamp> admitted_time_;
  Eigen::Vector3d admitted_position_mm_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond admitted_rotation_ = Eigen::Quaterniond::Identity();
};
}  // namespace detail

/// Admits only finite, rigid, timely poses inside the working volume. Other poses are kept without
/// a transform, with the cause. One gate for each tracked body. Not thread-safe.
template <class Body>
class PoseGate {
 public:
  /// Precondition: validate(options), otherwise a Bug.
  explicit PoseGate(const PoseGateOptions& options = {}) : options_(options), state_(options) {
    NAV_CHECK(validate(options).has_value());
  }

  Admission<Body> admit(const RawPose& raw) {
    const std::string name = std::string(Body::kName) + "ToTracker";
    auto verdict = state_.judge(raw, name);
    TrackedPose<Body> pose{raw.acquired, raw.status, std::nullopt};
    if (!verdict.rejection) {
      const auto rigid =
          rigid_from_matrix<frames::Tracker, Body>(raw.tracker_from_body, options_.rigid);
      NAV_CHECK(rigid.has_value());
      pose.tracker_from_body = *rigid;
    } else if (pose.status == TrackingStatus::kOk || pose.status == TrackingStatus::kUnknown) {
      pose.status = TrackingStatus::kInvalid;
    }
    return {std::move(pose), verdict.rejection, std::move(verdict.message)};
  }

 private:
  PoseGateOptions options_;
  detail::GateState state_;
};

}  // namespace nav::tracking
