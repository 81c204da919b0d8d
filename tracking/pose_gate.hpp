// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "nav/pose.hpp"
#include "tracking/delay_watch.hpp"

namespace nav::tracking {

/// What a pose must satisfy before anything else sees it.
struct PoseGateOptions {
  RigidTolerance rigid;
  double working_radius_mm = 10000;  ///< Largest |translation| in the Tracker frame.
  double max_speed_mm_per_s = 5000;  ///< Between neighbouring admitted poses of one body.
  /// Turn between neighbouring admitted poses less than a second apart, rad: a larger one is a body
  /// whose markers were mistaken for each other, not a hand. (0, pi].
  double max_turn_rad = 1.2;
  /// How far a stamp may lie after its reception; beyond it the device's clock is not believed.
  Duration max_future = std::chrono::milliseconds(100);
  /// How far the way from acquisition to reception may differ from what is usual for the stream;
  /// beyond it the device's clock has been set, or the stream was held up. > 0.
  Duration max_delay_change = std::chrono::milliseconds(60);
};

/// Refuses limits that are NaN or not positive.
Result<void> validate(const PoseGateOptions& options);

/// Why a pose was turned away. Names are stable, for the ledger and reports.
enum class PoseRejection { kStatus, kNotRigid, kOutsideVolume, kTime, kClock, kTooFast };
const char* to_string(PoseRejection cause);
/// Whether the time of a pose that was turned away for a cause may still be used: the fact that
/// there was no pose then.
inline bool has_usable_time(const std::optional<PoseRejection>& cause) {
  return cause != PoseRejection::kTime && cause != PoseRejection::kClock;
}

/// Verdict on one pose.
template <class Body>
struct Admission {
  TrackedPose<Body> pose;                  ///< Without a transform exactly when rejected.
  std::optional<PoseRejection> rejection;  ///< Absent when admitted.
  std::string message;                     ///< One sentence when rejected.
};

namespace detail {
/// Frame-independent part of the gate; state of one body.
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
  std::optional<Timestamp> newest_;  ///< Of every pose whose time was usable.
  std::optional<Timestamp> admitted_time_;
  Eigen::Vector3d admitted_position_mm_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond admitted_rotation_ = Eigen::Quaterniond::Identity();
};
}  // namespace detail

/// Lets only finite, rigid, timely poses inside the working volume through; keeps the fact and
/// the cause of every other. One gate per tracked body; not thread-safe.
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
