// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/navigator.hpp"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "nav/cause_words.hpp"

namespace nav::session {
namespace {

/// State of a pose apart from its age.
Safety doubt_safety(PoseDoubt doubt, const std::string& body) {
  if (doubt == PoseDoubt::kNone) return {SafetyState::kValid, ""};
  return {SafetyState::kDegraded, sentence(doubt, body)};
}

/// State of an image that repeats an older one: it is as old as that one.
Safety repetition_safety(const TrackedImage& frame, Duration stale_after) {
  if (!frame.repeats || frame.frame.acquired - *frame.repeats <= stale_after) {
    return {SafetyState::kValid, ""};
  }
  return {SafetyState::kStale, frame.doubt};
}

constexpr Duration kUnknownPeriod = std::chrono::milliseconds(50);

}  // namespace

Safety tracking_safety(const TrackedImage& frame) {
  if (frame.doubt.empty()) return {SafetyState::kValid, ""};
  return {SafetyState::kDegraded, frame.doubt};
}

Epoch ended(Epoch epoch, const std::string& cause) {
  for (Safety* input : {&epoch.ultrasound, &epoch.plane, &epoch.needle}) {
    *input = compose({*input, {SafetyState::kStale, cause}});
  }
  epoch.guidance.reset();
  return epoch;
}

Navigator::Navigator(const std::optional<ProbeCalibration>& calibration,
                     std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference,
                     const NavigatorOptions& options, Diagnostics& diagnostics)
    : options_(options),
      diagnostics_(diagnostics),
      pairer_(calibration, fixed_reference, options.pairing, diagnostics),
      needle_(options.pairing.gate, options.pairing.max_pose_gap, diagnostics),
      plausibility_(diagnostics),
      fixed_reference_(std::move(fixed_reference)) {}

Duration Navigator::frame_period() const {
  return options_.frame_period.value_or(image_period_.period().value_or(kUnknownPeriod));
}

Duration Navigator::needle_period() const {
  return options_.needle_period.value_or(pose_period_.period().value_or(kUnknownPeriod));
}

void Navigator::add_image(UltrasoundImage image) {
  ledger_.receive();
  image_period_.add(image.acquired);
  if (!options_.frame_period && image_period_.period()) {
    pairer_.expect_period(*image_period_.period());
    needle_.set_max_gap(
        std::max<Duration>(options_.pairing.max_pose_gap, 2 * *image_period_.period()));
  }
  pairer_.add_frame(std::move(image));
}

void Navigator::add_missing(const MissingImage& missing) {
  ledger_.receive();
  ledger_.reject(missing.cause);
  newest_rejection_ = missing.cause;
  diagnostics_.report(Severity::kWarning, "source", missing.message);
}

std::optional<double> Navigator::tracker_error_mm() const {
  double sum = 0;
  for (const ToolRole role : {ToolRole::kNeedle, ToolRole::kReference}) {
    if (role == ToolRole::kReference && fixed_reference_) continue;
    const auto found = tracker_errors_mm_.find(role);
    if (found == tracker_errors_mm_.end() || !found->second) return std::nullopt;
    sum += *found->second * *found->second;
  }
  return std::sqrt(sum);
}

void Navigator::add_pose(ToolRole role, const RawPose& pose,
                         std::optional<double> tracker_error_mm) {
  tracker_errors_mm_[role] = tracker_error_mm;
  plausibility_.add(role, pose);
  if (role == ToolRole::kProbe) {
    pairer_.add_probe_pose(pose);
  } else if (role == ToolRole::kReference) {
    pairer_.add_reference_pose(pose);
  } else if (role == ToolRole::kNeedle) {
    pose_period_.add(pose.acquired);
    needle_.add(pose);
  }
}

void Navigator::reject_pose(ToolRole role, const std::string& cause) {
  if (role == ToolRole::kProbe) {
    pairer_.reject_probe_pose(cause);
  } else if (role == ToolRole::kReference) {
    pairer_.reject_reference_pose(cause);
  } else if (role == ToolRole::kNeedle) {
    needle_.reject(cause);
  }
}

const tracking::StreamLedger& Navigator::ledger(ToolRole role) const {
  NAV_CHECK(role == ToolRole::kProbe || role == ToolRole::kReference || role == ToolRole::kNeedle);
  if (role == ToolRole::kProbe) return pairer_.probe().ledger();
  return role == ToolRole::kReference ? pairer_.reference().ledger() : needle_.ledger();
}

std::optional<Safety> Navigator::loss(bool images, ToolRole tool) const {
  if (images && !images_lost_.empty()) return Safety{SafetyState::kLost, images_lost_};
  for (const ToolRole role : {tool, ToolRole::kReference}) {
    if (role == ToolRole::kReference && fixed_reference_) continue;
    const auto lost = poses_lost_.find(role);
    if (lost != poses_lost_.end()) return Safety{SafetyState::kLost, lost->second};
  }
  return std::nullopt;
}

void Navigator::settle(Timestamp now, bool end_of_stream,
                       const std::function<void(const tracking::PairedImage&)>& listener) {
  for (const tracking::PairedImage& paired : pairer_.take_ready(now, end_of_stream)) {
    if (paired.tracked) {
      if (newest_ && !newest_shown_) ledger_.supersede();
      newest_ = paired.tracked;
      newest_shown_ = false;
      newest_rejection_.clear();
    } else {
      newest_rejection_ = paired.cause;
      ledger_.reject(paired.cause);
    }
    listener(paired);
  }
}

/// Puts the trouble of a device, or the cause for which images are rejected, before the cause of a
/// state that is not valid.
Safety Navigator::explained(Safety safety, bool images, ToolRole tool) const {
  if (safety.state == SafetyState::kValid) return safety;
  std::string why;
  if (images && !images_trouble_.empty()) why = "images: " + images_trouble_;
  for (const ToolRole role : {tool, ToolRole::kReference}) {
    const auto found = poses_trouble_.find(role);
    if (why.empty() && found != poses_trouble_.end() && !found->second.empty()) {
      why = std::string(to_string(role)) + ": " + found->second;
    }
  }
  if (why.empty() && images && !newest_rejection_.empty()) {
    why = "images come, but are rejected: " + words_of_cause(newest_rejection_);
  }
  if (why.empty()) return safety;
  safety.cause = why + "; " + safety.cause;
  return safety;
}

Epoch Navigator::refresh(Timestamp now) {
  Epoch epoch;
  epoch.now = now;
  epoch.placement =
      placement_ ? placement_->safety : Safety{SafetyState::kLost, "the CT is not registered"};
  epoch.ultrasound = {SafetyState::kLost, "no tracked ultrasound image yet"};
  if (newest_) {
    epoch.frame = newest_;
    epoch.frame_is_new = !newest_shown_;
    if (epoch.frame_is_new) ledger_.deliver();
    newest_shown_ = true;
    const FreshnessLimits limits = freshness_limits(frame_period());
    epoch.ultrasound =
        compose({freshness("the ultrasound image", newest_->frame.acquired, now, limits),
                 tracking_safety(*newest_), repetition_safety(*newest_, limits.stale_after)});
    epoch.ultrasound_until = newest_->frame.acquired + limits.stale_after;
    if (placement_) {
      epoch.ct_from_image = placement_->ct_from_reference * newest_->reference_from_image;
    }
  }
  if (const auto lost = loss(true, ToolRole::kProbe)) {
    epoch.ultrasound = *lost;
  } else if (!pairer_.without_calibration().empty()) {
    epoch.ultrasound = {SafetyState::kLost, pairer_.without_calibration()};
  }
  epoch.ultrasound = explained(epoch.ultrasound, true, ToolRole::kProbe);
  epoch.plane = compose({epoch.ultrasound, epoch.placement});
  refresh_needle(epoch);
  epoch.needle = explained(epoch.needle, false, ToolRole::kNeedle);
  return epoch;
}

Epoch Navigator::aged(Epoch epoch, Timestamp now) const {
  epoch.now = now;
  epoch.frame_is_new = false;
  if (epoch.frame) {
    const Safety image = freshness("the ultrasound image", epoch.frame->frame.acquired, now,
                                   freshness_limits(frame_period()));
    epoch.ultrasound = compose({epoch.ultrasound, image});
    epoch.plane = compose({epoch.plane, image});
  }
  if (epoch.needle_acquired) {
    epoch.needle = compose({epoch.needle, freshness("the needle pose", *epoch.needle_acquired, now,
                                                    freshness_limits(needle_period()))});
  }
  if (!epoch.needle.shows_numbers()) epoch.guidance.reset();
  return epoch;
}

void Navigator::refresh_needle(Epoch& epoch) const {
  epoch.needle = {SafetyState::kLost, "no needle pose"};
  if (const auto lost = loss(false, ToolRole::kNeedle)) epoch.needle = *lost;
  const auto newest = needle_.buffer().newest();
  if (!newest || !placement_ || loss(false, ToolRole::kNeedle)) return;
  if (!newest->tracker_from_body) {
    epoch.needle.cause = std::string("the needle is not tracked: ") + to_string(newest->status);
    return;
  }
  // Both bodies at one instant: the newest at which each has a pose.
  Timestamp instant = newest->acquired;
  std::vector<Safety> states{
      freshness("the needle pose", newest->acquired, epoch.now, freshness_limits(needle_period()))};
  if (!fixed_reference_) {
    const auto reference = pairer_.reference().buffer().newest();
    if (!reference || !reference->tracker_from_body) {
      epoch.needle.cause = "the patient reference is not tracked";
      return;
    }
    instant = std::min(instant, reference->acquired);
    states.push_back(freshness("the patient reference", reference->acquired, epoch.now,
                               freshness_limits(needle_period())));
  }
  const auto needle = needle_.buffer().at(instant);
  if (const auto* absence = std::get_if<tracking::PoseAbsence>(&needle)) {
    epoch.needle.cause = std::string("the needle has no pose at the time of the reference: ") +
                         words_of_cause(tracking::to_string(*absence));
    return;
  }
  const auto& tracker_from_needle = std::get<tracking::PoseAt<frames::Needle>>(needle);
  auto reference_from_tracker = fixed_reference_;
  if (!reference_from_tracker) {
    const auto reference = pairer_.reference().buffer().at(instant);
    if (const auto* absence = std::get_if<tracking::PoseAbsence>(&reference)) {
      epoch.needle.cause =
          std::string("the patient reference has no pose at the time of the needle: ") +
          words_of_cause(tracking::to_string(*absence));
      return;
    }
    const auto& tracker_from_reference = std::get<tracking::PoseAt<frames::Reference>>(reference);
    reference_from_tracker = tracker_from_reference.tracker_from_body.inverse();
    states.push_back(doubt_safety(tracker_from_reference.doubt, "the patient reference"));
  }
  states.push_back(doubt_safety(tracker_from_needle.doubt, "the needle"));
  states.push_back(placement_->safety);
  epoch.needle = compose(states);
  epoch.needle_acquired = instant;
  epoch.needle_until = instant + freshness_limits(needle_period()).stale_after;
  epoch.ct_from_needle = placement_->ct_from_reference * *reference_from_tracker *
                         tracker_from_needle.tracker_from_body;
  epoch.tracker_error_mm = tracker_error_mm();
  if (plan_ && epoch.needle.shows_numbers()) epoch.guidance = guide(*plan_, *epoch.ct_from_needle);
}

std::optional<Transform<frames::Ct, frames::Needle>> Navigator::needle_at(Timestamp time) const {
  const auto needle = needle_.buffer().at(time);
  const auto* tracker_from_needle = std::get_if<tracking::PoseAt<frames::Needle>>(&needle);
  if (!placement_ || tracker_from_needle == nullptr) return std::nullopt;
  auto reference_from_tracker = fixed_reference_;
  if (!reference_from_tracker) {
    const auto reference = pairer_.reference().buffer().at(time);
    const auto* pose = std::get_if<tracking::PoseAt<frames::Reference>>(&reference);
    if (pose == nullptr) return std::nullopt;
    reference_from_tracker = pose->tracker_from_body.inverse();
  }
  return placement_->ct_from_reference * *reference_from_tracker *
         tracker_from_needle->tracker_from_body;
}

std::optional<Eigen::Matrix4d> Navigator::tracker_from(ToolRole role, Timestamp time) const {
  const auto matrix = [](const auto& found) -> std::optional<Eigen::Matrix4d> {
    if (found.index() == 1) return std::nullopt;
    return std::get<0>(found).tracker_from_body.matrix();
  };
  NAV_CHECK(role == ToolRole::kProbe || role == ToolRole::kReference || role == ToolRole::kNeedle);
  if (role == ToolRole::kProbe) return matrix(pairer_.probe().buffer().at(time));
  if (role == ToolRole::kNeedle) return matrix(needle_.buffer().at(time));
  if (fixed_reference_) return fixed_reference_->inverse().matrix();
  return matrix(pairer_.reference().buffer().at(time));
}

void Navigator::finish() {
  if (newest_ && !newest_shown_) {
    ledger_.supersede();
    newest_shown_ = true;
  }
}

std::map<std::string, std::uint64_t> Navigator::rejected_poses() const {
  std::map<std::string, std::uint64_t> all;
  for (const ToolRole role : {ToolRole::kProbe, ToolRole::kReference, ToolRole::kNeedle}) {
    for (const auto& [cause, count] : ledger(role).rejected()) {
      all[std::string(to_string(role)) + "." + cause] = count;
    }
  }
  return all;
}

}  // namespace nav::session
