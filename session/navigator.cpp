// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/navigator.hpp"

#include <algorithm>

namespace nav::session {
namespace {

constexpr std::size_t kPoseCapacity = 1024;

/// What a pose's own state is, apart from its age.
template <class Pose>
Safety status_safety(const Pose& pose, const std::string& body) {
  if (pose.status == TrackingStatus::kOk) return {SafetyState::kValid, ""};
  return {SafetyState::kDegraded, "the tracker gave no status for " + body};
}

}  // namespace

Safety tracking_safety(const TrackedFrame& frame) {
  if (!frame.degraded) return {SafetyState::kValid, ""};
  return {SafetyState::kDegraded,
          "the tracker gave no status for the probe or the patient reference"};
}

Epoch ended(Epoch epoch, const std::string& cause) {
  for (Safety* input : {&epoch.ultrasound, &epoch.plane, &epoch.needle}) {
    *input = compose({*input, {SafetyState::kStale, cause}});
  }
  epoch.guidance.reset();
  return epoch;
}

Navigator::Navigator(const Transform<frames::Probe, frames::Image>& probe_from_image,
                     std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference,
                     const NavigatorOptions& options, Diagnostics& diagnostics)
    : options_(options),
      diagnostics_(diagnostics),
      pairer_(probe_from_image, fixed_reference, options.pairing, diagnostics),
      needle_gate_(options.pairing.gate),
      needle_poses_(kPoseCapacity, options.pairing.max_pose_gap),
      reference_gate_(options.pairing.gate),
      reference_poses_(kPoseCapacity, options.pairing.max_pose_gap),
      fixed_reference_(std::move(fixed_reference)) {}

void Navigator::on_event(const SessionEvent& event) {
  if (const auto* frame = std::get_if<UltrasoundFrame>(&event.what)) {
    ledger_.receive();
    pairer_.add_frame(*frame);
  } else if (const auto* missing = std::get_if<MissingFrame>(&event.what)) {
    ledger_.receive();
    ledger_.reject(missing->cause);
    diagnostics_.report(Severity::kWarning, "source", missing->message);
  } else if (const auto* probe = std::get_if<ProbePose>(&event.what)) {
    pairer_.add_probe_pose(probe->raw);
  } else if (const auto* reference = std::get_if<ReferencePose>(&event.what)) {
    pairer_.add_reference_pose(reference->raw);
    const auto admission = reference_gate_.admit(reference->raw);
    if (tracking::has_usable_time(admission.rejection)) {
      reference_poses_.push(admission.pose);
    }
  } else if (const auto* needle = std::get_if<NeedlePose>(&event.what)) {
    const auto admission = needle_gate_.admit(needle->raw);
    if (admission.rejection) {
      ++rejected_needle_poses_[std::string("Needle.") + tracking::to_string(*admission.rejection)];
      diagnostics_.report(Severity::kWarning, "tracking.gate", admission.message);
    }
    if (tracking::has_usable_time(admission.rejection)) {
      needle_poses_.push(admission.pose);
    }
  }
}

void Navigator::settle(Timestamp now, bool end_of_stream,
                       const std::function<void(const tracking::PairedFrame&)>& listener) {
  for (const tracking::PairedFrame& paired : pairer_.take_ready(now, end_of_stream)) {
    if (paired.tracked) {
      if (newest_ && !newest_shown_) ledger_.supersede();
      newest_ = paired.tracked;
      newest_shown_ = false;
    } else {
      ledger_.reject(paired.cause);
    }
    listener(paired);
  }
}

Epoch Navigator::refresh(Timestamp now) {
  Epoch epoch;
  epoch.now = now;
  epoch.placement =
      placement_ ? placement_->safety : Safety{SafetyState::kLost, "the CT is not registered"};
  epoch.ultrasound = {SafetyState::kLost, "no tracked ultrasound picture yet"};
  if (newest_) {
    epoch.frame = newest_;
    epoch.frame_is_new = !newest_shown_;
    if (epoch.frame_is_new) ledger_.show();
    newest_shown_ = true;
    epoch.ultrasound = compose({freshness("the ultrasound picture", newest_->frame.acquired, now,
                                          freshness_limits(options_.frame_period)),
                                tracking_safety(*newest_)});
    if (placement_) {
      epoch.ct_from_image = placement_->ct_from_reference * newest_->reference_from_image;
    }
  }
  epoch.plane = compose({epoch.ultrasound, epoch.placement});
  refresh_needle(epoch);
  return epoch;
}

Epoch Navigator::aged(Epoch epoch, Timestamp now) const {
  epoch.now = now;
  epoch.frame_is_new = false;
  if (epoch.frame) {
    const Safety picture = freshness("the ultrasound picture", epoch.frame->frame.acquired, now,
                                     freshness_limits(options_.frame_period));
    epoch.ultrasound = compose({epoch.ultrasound, picture});
    epoch.plane = compose({epoch.plane, picture});
  }
  if (epoch.needle_acquired) {
    epoch.needle = compose({epoch.needle, freshness("the needle pose", *epoch.needle_acquired, now,
                                                    freshness_limits(options_.needle_period))});
  }
  if (!epoch.needle.shows_numbers()) epoch.guidance.reset();
  return epoch;
}

void Navigator::refresh_needle(Epoch& epoch) const {
  const auto newest = needle_poses_.newest();
  epoch.needle = {SafetyState::kLost, "no needle pose"};
  if (!newest || !placement_) return;
  if (!newest->tracker_from_body) {
    epoch.needle.cause = std::string("the needle is not tracked: ") + to_string(newest->status);
    return;
  }
  auto reference_from_tracker = fixed_reference_;
  Safety reference{SafetyState::kValid, ""};
  Timestamp acquired = newest->acquired;
  if (!reference_from_tracker) {
    const auto pose = reference_poses_.newest();
    if (!pose || !pose->tracker_from_body) {
      epoch.needle.cause = "the patient reference is not tracked";
      return;
    }
    reference_from_tracker = pose->tracker_from_body->inverse();
    acquired = std::min(acquired, pose->acquired);
    reference = compose({freshness("the patient reference", pose->acquired, epoch.now,
                                   freshness_limits(options_.needle_period)),
                         status_safety(*pose, "the patient reference")});
  }
  epoch.needle = compose({freshness("the needle pose", newest->acquired, epoch.now,
                                    freshness_limits(options_.needle_period)),
                          reference, status_safety(*newest, "the needle"), placement_->safety});
  epoch.needle_acquired = acquired;
  epoch.ct_from_needle =
      placement_->ct_from_reference * *reference_from_tracker * *newest->tracker_from_body;
  if (plan_ && epoch.needle.shows_numbers()) epoch.guidance = guide(*plan_, *epoch.ct_from_needle);
}

std::optional<Transform<frames::Ct, frames::Needle>> Navigator::needle_at(Timestamp time) const {
  const auto needle = needle_poses_.at(time);
  const auto* tracker_from_needle = std::get_if<tracking::PoseAt<frames::Needle>>(&needle);
  if (!placement_ || tracker_from_needle == nullptr) return std::nullopt;
  auto reference_from_tracker = fixed_reference_;
  if (!reference_from_tracker) {
    const auto reference = reference_poses_.at(time);
    const auto* pose = std::get_if<tracking::PoseAt<frames::Reference>>(&reference);
    if (pose == nullptr) return std::nullopt;
    reference_from_tracker = pose->tracker_from_body.inverse();
  }
  return placement_->ct_from_reference * *reference_from_tracker *
         tracker_from_needle->tracker_from_body;
}

void Navigator::finish() {
  if (newest_ && !newest_shown_) {
    ledger_.supersede();
    newest_shown_ = true;
  }
}

std::map<std::string, std::uint64_t> Navigator::rejected_poses() const {
  auto all = pairer_.rejected_poses();
  all.insert(rejected_needle_poses_.begin(), rejected_needle_poses_.end());
  return all;
}

}  // namespace nav::session
