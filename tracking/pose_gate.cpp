// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/pose_gate.hpp"

#include <cmath>
#include <numbers>
#include <sstream>

namespace nav::tracking {

const char* to_string(PoseRejection cause) {
  switch (cause) {
    case PoseRejection::kStatus:
      return "status_not_ok";
    case PoseRejection::kNotRigid:
      return "not_rigid";
    case PoseRejection::kOutsideVolume:
      return "outside_working_volume";
    case PoseRejection::kTime:
      return "time_not_increasing";
    case PoseRejection::kClock:
      return "clock_not_believed";
    case PoseRejection::kTooFast:
      return "too_fast";
  }
  return "unknown";
}

Result<void> validate(const PoseGateOptions& options) {
  if (!(options.working_radius_mm > 0) || !std::isfinite(options.working_radius_mm)) {
    return Error{ErrorCode::kUsage, "pose gate: expected working_radius_mm > 0, found " +
                                        std::to_string(options.working_radius_mm)};
  }
  if (!(options.max_speed_mm_per_s > 0)) {
    return Error{ErrorCode::kUsage, "pose gate: expected max_speed_mm_per_s > 0, found " +
                                        std::to_string(options.max_speed_mm_per_s)};
  }
  if (!(options.rigid.orthonormality > 0 && options.rigid.orthonormality < 0.1)) {
    return Error{ErrorCode::kUsage, "pose gate: expected an orthonormality tolerance in (0, 0.1)"};
  }
  if (!(options.max_turn_rad > 0 && options.max_turn_rad <= std::numbers::pi)) {
    return Error{ErrorCode::kUsage, "pose gate: expected max_turn_rad in (0, pi], found " +
                                        std::to_string(options.max_turn_rad)};
  }
  if (options.max_delay_change <= Duration::zero()) {
    return Error{ErrorCode::kUsage, "pose gate: expected max_delay_change > 0"};
  }
  return {};
}

namespace detail {
namespace {

std::string at(const RawPose& raw, const std::string& name) {
  return name + " at " + std::to_string(to_seconds(raw.acquired)) + " s: ";
}

}  // namespace

GateState::Verdict GateState::judge_time(const RawPose& raw, const std::string& name) {
  std::ostringstream text;
  text << at(raw, name);
  // Every pose is checked: otherwise a clock that was set back would be reported as "too old" only.
  const bool believed = delay_.believes(raw.acquired, raw.received);
  if (newest_ && raw.acquired <= *newest_) {
    text << "expected a time after " << to_seconds(*newest_) << " s";
    return {PoseRejection::kTime, text.str()};
  }
  if (raw.acquired - raw.received > options_.max_future) {
    text << "expected a time at most " << to_seconds(options_.max_future)
         << " s after its reception at " << to_seconds(raw.received) << " s";
    return {PoseRejection::kTime, text.str()};
  }
  if (!believed) {
    text << "expected to be received " << 1e3 * to_seconds(delay_.usual())
         << " ms after acquisition as usual, found "
         << 1e3 * to_seconds(raw.received - raw.acquired)
         << " ms: the device's clock was set, or its data were held up";
    return {PoseRejection::kClock, text.str()};
  }
  return {std::nullopt, ""};
}

GateState::Verdict GateState::judge_motion(const RawPose& raw, const Eigen::Quaterniond& rotation,
                                           const std::string& name) const {
  std::ostringstream text;
  text << at(raw, name);
  const Eigen::Vector3d position_mm = raw.tracker_from_body.topRightCorner<3, 1>();
  if (position_mm.norm() > options_.working_radius_mm) {
    text << "expected a position within " << options_.working_radius_mm
         << " mm of the tracker, found " << position_mm.norm() << " mm";
    return {PoseRejection::kOutsideVolume, text.str()};
  }
  if (!admitted_time_) return {std::nullopt, ""};
  const double seconds = to_seconds(raw.acquired - *admitted_time_);
  // After a second without poses the body may be anywhere, so any motion is accepted.
  if (seconds >= 1.0) return {std::nullopt, ""};
  const double speed = (position_mm - admitted_position_mm_).norm() / seconds;
  if (speed > options_.max_speed_mm_per_s) {
    text << "expected at most " << options_.max_speed_mm_per_s << " mm/s, found " << speed
         << " mm/s";
    return {PoseRejection::kTooFast, text.str()};
  }
  const double turn = rotation.angularDistance(admitted_rotation_);
  if (turn > options_.max_turn_rad) {
    text << "expected a turn of at most " << options_.max_turn_rad << " rad since "
         << to_seconds(*admitted_time_) << " s, found " << turn << " rad";
    return {PoseRejection::kTooFast, text.str()};
  }
  return {std::nullopt, ""};
}

GateState::Verdict GateState::judge(const RawPose& raw, const std::string& name) {
  if (auto time = judge_time(raw, name); time.rejection) return time;
  newest_ = raw.acquired;

  if (raw.status != TrackingStatus::kOk && raw.status != TrackingStatus::kUnknown) {
    return {PoseRejection::kStatus,
            at(raw, name) + "expected status ok, found " + nav::to_string(raw.status)};
  }
  const auto rotation =
      nav::detail::rotation_from_matrix(raw.tracker_from_body, name, options_.rigid);
  if (!rotation) {
    return {PoseRejection::kNotRigid,
            rotation.error().message + " at " + std::to_string(to_seconds(raw.acquired)) + " s"};
  }
  if (auto motion = judge_motion(raw, *rotation, name); motion.rejection) return motion;
  admitted_time_ = raw.acquired;
  admitted_position_mm_ = raw.tracker_from_body.topRightCorner<3, 1>();
  admitted_rotation_ = *rotation;
  return {std::nullopt, ""};
}

}  // namespace detail
}  // namespace nav::tracking
