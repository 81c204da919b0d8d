// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/tissue_follower.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "nav/statistics.hpp"
#include "nav/threads.hpp"
#include "registration/prepared.hpp"
#include "session/pose_log.hpp"

namespace nav::session {
namespace {

using registration::LiveState;
using registration::LiveUpdate;

/// The part of the CT that an image can reach while the tissue moves.
Eigen::AlignedBox3d box_around(const TrackedImage& image,
                               const Transform<frames::Ct, frames::Reference>& accepted,
                               double margin_mm) {
  Eigen::AlignedBox3d box;
  for (const auto& corner : survey_of(image).corners) box.extend((accepted * corner).mm);
  return {(box.min().array() - margin_mm).matrix(), (box.max().array() + margin_mm).matrix()};
}

/// Prepared at once beyond what an image needs, so that a sweep does not extend it every time.
constexpr double kAheadMm = 20;

Result<std::shared_ptr<const registration::CtChannels>> channels_in(
    const Volume& ct, const registration::CtBox& box) {
  const registration::LiveOptions options;
  auto channels =
      registration::make_ct_channels(ct, box, registration::sigma_of(options.level.sample_step_mm));
  if (!channels) return channels.error();
  return std::make_shared<const registration::CtChannels>(std::move(*channels));
}

Safety safety_of(const LiveUpdate& update) {
  switch (update.state) {
    case LiveState::kFollowing:
      return {SafetyState::kValid, ""};
    case LiveState::kHolding:
      return {SafetyState::kStale, "the CT lies where an earlier image put it: " + update.cause};
    case LiveState::kDrifted:
      return {SafetyState::kDegraded, "the patient has moved, register anew: " + update.cause};
    case LiveState::kLost:
      break;
  }
  return {SafetyState::kLost, update.cause};
}

}  // namespace

Result<TissueFollower> TissueFollower::create(std::shared_ptr<const Volume> ct,
                                              const CtPlacement& accepted,
                                              const TrackedImage& first, int threads,
                                              Diagnostics& diagnostics) {
  registration::LiveOptions options;
  constexpr int kMostThreads = 64;  // Limit of LiveOptions::threads.
  options.threads = usable_threads(threads > 0 ? std::min(threads, kMostThreads) : kMostThreads);
  const auto around = box_around(first, accepted.ct_from_reference, options.jump_mm + kAheadMm);
  const registration::CtBox box{around.min(), around.max()};
  auto channels = channels_in(*ct, box);
  if (!channels) return channels.error();
  auto live = registration::LiveRegistration::create(*std::move(channels),
                                                     accepted.ct_from_reference, options);
  if (!live) return live.error();
  return TissueFollower(std::move(*live), std::move(ct), box, accepted, diagnostics);
}

Result<void> TissueFollower::extend_to(const TrackedImage& image) {
  const registration::LiveOptions options;
  const auto needed = box_around(image, live_.accepted(), options.jump_mm);
  const Eigen::AlignedBox3d have(box_.low, box_.high);
  if (have.contains(needed)) return {};
  const auto grown = have.merged(box_around(image, live_.accepted(), options.jump_mm + kAheadMm));
  const registration::CtBox box{grown.min(), grown.max()};
  auto channels = channels_in(*ct_, box);
  if (!channels) return channels.error();
  live_.replace_ct(*std::move(channels));
  box_ = box;
  return {};
}

TissueFollower::TissueFollower(registration::LiveRegistration live,
                               std::shared_ptr<const Volume> ct, const registration::CtBox& box,
                               const CtPlacement& accepted, Diagnostics& diagnostics)
    : live_(std::move(live)),
      ct_(std::move(ct)),
      box_(box),
      diagnostics_(&diagnostics),
      placement_(accepted),
      text_(
          "sequence,acquired_ns,state,cost,displacement_mm,mean_displacement_mm,predicted_rms_mm,"
          "distinctness,"
          "tx_mm,ty_mm,tz_mm,qx,qy,qz,qw\n") {}

CtPlacement TissueFollower::follow(const TrackedImage& image) {
  const auto start = std::chrono::steady_clock::now();
  const auto extended = extend_to(image);
  const auto update = extended ? live_.update(image) : extended.error();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  update_s_.push_back(took.count());
  if (!update) {
    ++states_["refused"];
    // A CT that was lost stays lost.
    placement_.safety = compose({placement_.safety, {SafetyState::kStale, update.error().message}});
    diagnostics_->report(Severity::kWarning, "follow", update.error().message);
    return placement_;
  }
  ++states_[registration::to_string(update->state)];
  costs_.push_back(update->cost);
  largest_displacement_mm_ = std::max(largest_displacement_mm_, update->displacement_mm);
  note_state(*update, image);
  log(*update, image);
  placement_ = {update->ct_from_reference, safety_of(*update)};
  return placement_;
}

/// An alarm is said once, when it comes.
void TissueFollower::note_state(const LiveUpdate& update, const TrackedImage& image) {
  if (last_ == update.state) return;
  last_ = update.state;
  if (update.state != LiveState::kDrifted && update.state != LiveState::kLost) return;
  alarms_.push_back(
      {to_seconds(image.frame.acquired), registration::to_string(update.state), update.cause});
  diagnostics_->report(Severity::kWarning, "follow", safety_of(update).cause);
}

void TissueFollower::log(const LiveUpdate& update, const TrackedImage& image) {
  text_ += std::to_string(image.frame.sequence) + ',' +
           std::to_string(image.frame.acquired.time_since_epoch().count()) + ',' +
           registration::to_string(update.state);
  for (const double value : {update.cost, update.displacement_mm, update.mean_displacement_mm,
                             update.predicted_rms_mm}) {
    text_ += ',' + shortest_text(value);
  }
  text_ += ',';
  if (std::isfinite(update.distinctness)) text_ += shortest_text(update.distinctness);
  const auto& pose = update.ct_from_reference;
  text_ += pose_columns(pose.translation_mm(), pose.rotation()) + '\n';
}

TissueFollower::Summary TissueFollower::summary() const {
  Summary summary;
  summary.images = update_s_.size();
  summary.states = states_;
  summary.alarms = alarms_;
  summary.largest_displacement_mm = largest_displacement_mm_;
  summary.cost_median = median(costs_);
  summary.update_s_median = median(update_s_);
  summary.updates_over_limit = std::count_if(update_s_.begin(), update_s_.end(),
                                             [](double s) { return s > kUpdateLimit_s; });
  return summary;
}

}  // namespace nav::session
