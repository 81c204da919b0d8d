// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/pose_gate.hpp"

#include <cmath>
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
  return {};
}

namespace detail {

GateState::Verdict GateState::judge(const RawPose& raw, const std::string& name) {
  std::ostringstream text;
  const auto at = [&] { return name + " at " + std::to_string(to_seconds(raw.acquired)) + " s: "; };

  if (newest_ && raw.acquired <= *newest_) {
    text << at() << "expected a time after " << to_seconds(*newest_) << " s";
    return {PoseRejection::kTime, text.str()};
  }
  if (raw.acquired - raw.received > options_.max_future) {
    text << at() << "expected a time at most " << to_seconds(options_.max_future)
         << " s after its reception at " << to_seconds(raw.received) << " s";
    return {PoseRejection::kTime, text.str()};
  }
  newest_ = raw.acquired;

  if (raw.status != TrackingStatus::kOk && raw.status != TrackingStatus::kUnknown) {
    text << at() << "expected status ok, found " << nav::to_string(raw.status);
    return {PoseRejection::kStatus, text.str()};
  }
  const auto rotation =
      nav::detail::rotation_from_matrix(raw.tracker_from_body, name, options_.rigid);
  if (!rotation) {
    return {PoseRejection::kNotRigid,
            rotation.error().message + " at " + std::to_string(to_seconds(raw.acquired)) + " s"};
  }
  const Eigen::Vector3d position_mm = raw.tracker_from_body.topRightCorner<3, 1>();
  if (position_mm.norm() > options_.working_radius_mm) {
    text << at() << "expected a position within " << options_.working_radius_mm
         << " mm of the tracker, found " << position_mm.norm() << " mm";
    return {PoseRejection::kOutsideVolume, text.str()};
  }
  if (admitted_time_) {
    const double seconds = to_seconds(raw.acquired - *admitted_time_);
    const double speed = (position_mm - admitted_position_mm_).norm() / seconds;
    // After a second of silence the body may be anywhere: the gate must open again.
    if (seconds < 1.0 && speed > options_.max_speed_mm_per_s) {
      text << at() << "expected at most " << options_.max_speed_mm_per_s << " mm/s, found " << speed
           << " mm/s";
      return {PoseRejection::kTooFast, text.str()};
    }
  }
  admitted_time_ = raw.acquired;
  admitted_position_mm_ = position_mm;
  return {std::nullopt, ""};
}

}  // namespace detail
}  // namespace nav::tracking
