// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "nav/diagnostics.hpp"
#include "nav/pose.hpp"
#include "tracking/clock_model.hpp"

namespace nav::tracking {

/// Conditions that a pose must meet before it is used.
struct PoseGateOptions {
  RigidTolerance rigid;
  double working_radius_mm = 10000;  ///< Largest |translation| in the Tracker frame.
  /// Speed and turn since the last admitted pose, if that is less than a second old, > 0. A body
  /// that seems to be faster was not moved by a hand: markers were confused.
  double max_speed_mm_per_s = 2000;
  double max_turn_rad_per_s = 15;
  /// Limits of a hand, for the distance from the path that the last poses continue: half of it
  /// times the square of the time since the last pose. > 0.
  double max_acceleration_mm_per_s2 = 10000;
  double max_acceleration_rad_per_s2 = 60;
  /// True for the patient's reference: it was moved when it is faster than a patient. Its poses are
  /// then degraded until it is back in its place, or confirmed.
  bool patient = false;
  double max_patient_speed_mm_per_s = 100;  ///< > 0.
  double max_patient_turn_rad_per_s = 0.5;  ///< > 0.
  /// A pose of a tool that does not change for longer than this is degraded: trackers repeat the
  /// last pose of a tool that they do not see. The last digits may change, by less than any tracker
  /// is still. Absent for the reference, which may lie still.
  Duration max_stuck = std::chrono::milliseconds(250);
  /// It is degraded sooner if the tool, at the speed that it had, would have moved by more than
  /// this, > 0. A turn counts at 100 mm from the body.
  double max_stuck_mm = 1;
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
enum class PoseRejection {
  kStatus,
  kNotRigid,
  kOutsideVolume,
  kTime,
  kClock,
  kTooFast,
  kUnconfirmed,  ///< Off the path of the poses before; withheld until two more poses agree with it.
};
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
  /// One sentence when rejected, and when admitted poses begin to be degraded; otherwise empty.
  std::string message;
  /// When poses begin that do not change to the last digit.
  std::optional<Finding> finding = std::nullopt;
};

namespace detail {
/// Frame-independent part of the gate: the state of one body.
class GateState {
 public:
  /// \p name: name of the transform in messages ("ProbeToTracker").
  GateState(const PoseGateOptions& options, std::string name)
      : options_(options),
        name_(std::move(name)),
        clock_({.tolerance = options.max_delay_change}) {}
  struct Verdict {
    std::optional<PoseRejection> rejection;
    std::string message;
    PoseDoubt doubt = PoseDoubt::kNone;
    std::optional<Finding> finding = std::nullopt;
  };
  Verdict judge(const RawPose& raw);
  /// Rotation of the pose that was admitted last.
  [[nodiscard]] const Eigen::Quaterniond& rotation() const { return path_[0].rotation; }
  void confirm_place() { place_before_.reset(); }
  [[nodiscard]] bool moved() const { return place_before_.has_value(); }

 private:
  /// A pose on the path of a body.
  struct Place {
    Timestamp time;
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  };
  /// Distance of a pose from the path that the poses before continue.
  struct Distance {
    double mm = 0;
    double rad = 0;
  };

  [[nodiscard]] Verdict judge_time(const RawPose& raw);
  [[nodiscard]] Verdict judge_motion(const Place& place);
  [[nodiscard]] Verdict leave_path(const Place& place, const Distance& off, const Distance& limit);
  [[nodiscard]] static bool is_identity(const Place& place);
  [[nodiscard]] Distance off_path(const Place& place) const;
  [[nodiscard]] Distance hardest(const Place& place) const;
  [[nodiscard]] Distance limit(const Place& place) const;
  void follow(const Place& place);
  [[nodiscard]] static bool is_same(const Eigen::Matrix4d& a, const Eigen::Matrix4d& b);
  [[nodiscard]] bool is_stuck(const RawPose& raw);
  [[nodiscard]] Finding stuck_finding(const RawPose& raw) const;

  [[nodiscard]] std::string at(Timestamp time) const;
  [[nodiscard]] double lost_after_s() const;

  PoseGateOptions options_;
  std::string name_;
  ClockModel clock_;
  bool clock_degraded_ = false;
  std::optional<Timestamp> newest_;  ///< Newest usable time, of admitted and rejected poses.
  double usual_s_ = 0;               ///< Usual time between poses.
  // The newest two admitted poses, and the usual distance from the path.
  std::array<Place, 2> path_{};
  int path_count_ = 0;
  Distance usual_{};
  // Poses off the path that may be the beginning of another one.
  std::array<Place, 2> aside_{};
  int aside_count_ = 0;
  bool impossible_ = false;  ///< Since the path's end a pose was where no hand could move the body.
  std::optional<Place> place_before_;  ///< Place of the patient's reference before it was moved.
  // The pose that does not change.
  Eigen::Matrix4d same_ = Eigen::Matrix4d::Zero();
  Timestamp same_since_{};
  int same_count_ = 0;
  bool said_stuck_ = false;
  double speed_mm_s_ = 0;  ///< Newest speed, while the pose changed; a turn counts at 100 mm.
};
}  // namespace detail

/// Admits only finite, rigid, timely poses inside the working volume. Other poses are kept without
/// a transform, with the cause. One gate for each tracked body. Not thread-safe.
template <class Body>
class PoseGate {
 public:
  /// Precondition: validate(options), otherwise a Bug.
  explicit PoseGate(const PoseGateOptions& options = {})
      : state_(options, std::string(Body::kName) + "ToTracker") {
    NAV_CHECK(validate(options).has_value());
  }

  Admission<Body> admit(const RawPose& raw) {
    auto verdict = state_.judge(raw);
    TrackedPose<Body> pose{raw.acquired, raw.status, std::nullopt};
    if (!verdict.rejection) {
      pose.tracker_from_body = Transform<frames::Tracker, Body>(
          state_.rotation(), raw.tracker_from_body.template topRightCorner<3, 1>());
      pose.doubt = verdict.doubt;
    } else if (pose.status == TrackingStatus::kOk || pose.status == TrackingStatus::kUnknown) {
      pose.status = TrackingStatus::kInvalid;
    }
    return {std::move(pose), verdict.rejection, std::move(verdict.message),
            std::move(verdict.finding)};
  }

  /// Accepts the new place of the patient's reference after it was moved.
  void confirm_place() { state_.confirm_place(); }
  /// True from the time when the patient's reference was moved until it is back or confirmed.
  [[nodiscard]] bool moved() const { return state_.moved(); }

 private:
  detail::GateState state_;
};

}  // namespace nav::tracking
