// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/simulated_tracker.hpp"

#include <algorithm>

#include "sim/random.hpp"

namespace nav::sim {
namespace {

Eigen::Matrix4d true_pose(const Procedure& procedure, TrackedBody body, Timestamp time) {
  switch (body) {
    case TrackedBody::kProbe:
      return procedure.tracker_from_probe(time).matrix();
    case TrackedBody::kReference:
      return procedure.tracker_from_reference(time).matrix();
    case TrackedBody::kNeedle:
      return procedure.tracker_from_needle(time).matrix();
  }
  NAV_CHECK(false, "no such body");
  return {};
}

/// Adds noise about the body's own origin.
void disturb(Eigen::Matrix4d& pose, const TrackerModel& model, std::uint64_t seed,
             std::uint64_t stream, std::uint64_t sample) {
  Eigen::Vector3d shift;
  Eigen::Vector3d turn;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t counter = 6 * sample + static_cast<std::uint64_t>(axis);
    shift[axis] = model.noise_mm * normal_at(seed, stream, counter);
    turn[axis] = model.noise_rad * normal_at(seed, stream, counter + 3);
  }
  pose.topRightCorner<3, 1>() += shift;
  if (turn.norm() > 0) {
    const Eigen::Matrix3d small =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    pose.topLeftCorner<3, 3>() = (pose.topLeftCorner<3, 3>() * small).eval();
  }
}

Error timeout(const char* what) {
  return Error{ErrorCode::kTimeout, std::string(what) + ": no sample before the deadline"};
}
Error ended(const char* what, bool stopped) {
  if (stopped) return Error{ErrorCode::kCancelled, std::string(what) + ": stopped"};
  return Error{ErrorCode::kEndOfStream, std::string(what) + ": the procedure has ended"};
}

}  // namespace

SimulatedTracker::SimulatedTracker(const Procedure& procedure, TrackedBody body) {
  const TrackerModel& model = procedure.options().tracker;
  const std::uint64_t seed = procedure.options().seed;
  const std::uint64_t stream = 0x706f7365 + 16 * static_cast<std::uint64_t>(body);
  const Timestamp begin = procedure.phases().front().begin - kTrackerLeadIn;
  const Timestamp end = procedure.end() + kTrackerLeadIn;
  int hidden = 0;
  for (std::uint64_t i = 0;; ++i) {
    RawPose pose;
    pose.acquired = begin + from_seconds(static_cast<double>(i) / model.rate_hz);
    if (pose.acquired > end) break;
    const double wait = unit_from_bits(hash_bits(seed, stream + 1, i));
    pose.received = pose.acquired + model.latency + from_seconds(wait * to_seconds(model.jitter));
    if (hidden > 0) {
      --hidden;
    } else if (unit_from_bits(hash_bits(seed, stream + 2, i)) <= model.dropout_probability) {
      hidden = model.dropout_samples - 1;
    } else {
      pose.status = TrackingStatus::kOk;
      pose.tracker_from_body = true_pose(procedure, body, pose.acquired);
      disturb(pose.tracker_from_body, model, seed, stream, i);
    }
    if (pose.status != TrackingStatus::kOk) pose.status = TrackingStatus::kOccluded;
    poses_.push_back(pose);
  }
  std::stable_sort(poses_.begin(), poses_.end(),
                   [](const RawPose& a, const RawPose& b) { return a.received < b.received; });
}

Timestamp SimulatedTracker::next_arrival() const {
  return position_ < poses_.size() ? poses_[position_].received : Timestamp::max();
}

Result<RawPose> SimulatedTracker::next(Deadline deadline) {
  constexpr const char* kName = "simulated tracker";
  if (stopped_ || position_ >= poses_.size()) return ended(kName, stopped_);
  if (next_arrival() > deadline) return timeout(kName);
  return poses_[position_++];
}

SimulatedProbe::SimulatedProbe(const Procedure& procedure)
    : procedure_(&procedure),
      simulator_(procedure.phantom(), procedure.options().probe, procedure.options().seed) {}

Timestamp SimulatedProbe::next_arrival() const {
  if (position_ >= procedure_->frame_count()) return Timestamp::max();
  return procedure_->frame_time(position_) + procedure_->options().image_timing.latency;
}

Result<UltrasoundFrame> SimulatedProbe::next(Deadline deadline) {
  constexpr const char* kName = "simulated probe";
  if (stopped_ || position_ >= procedure_->frame_count()) return ended(kName, stopped_);
  const Timestamp received = next_arrival();
  if (received > deadline) return timeout(kName);
  const Timestamp physical = procedure_->frame_time(position_);
  std::optional<Transform<frames::Ct, frames::Needle>> needle;
  if (physical >= procedure_->phases().back().begin) needle = procedure_->ct_from_needle(physical);
  UltrasoundFrame frame =
      simulator_.simulate(procedure_->ct_from_image(physical),
                          physical + procedure_->options().image_timing.stamp_offset,
                          static_cast<std::uint64_t>(position_), needle);
  frame.received = received;
  ++position_;
  return frame;
}

}  // namespace nav::sim
