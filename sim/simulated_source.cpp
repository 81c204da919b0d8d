// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/simulated_source.hpp"

namespace nav::sim {
namespace {

/// Poses of a needle's straight tip, from those of its hub.
class TipPoses final : public PoseStream {
 public:
  TipPoses(std::unique_ptr<PoseStream> hub, const Eigen::Matrix4d& hub_from_tip)
      : hub_(std::move(hub)), hub_from_tip_(hub_from_tip) {}
  Result<RawPose> next(Deadline deadline) override {
    auto pose = hub_->next(deadline);
    if (pose) pose->tracker_from_body = (pose->tracker_from_body * hub_from_tip_).eval();
    return pose;
  }
  void stop() noexcept override { hub_->stop(); }

 private:
  std::unique_ptr<PoseStream> hub_;
  Eigen::Matrix4d hub_from_tip_;
};

}  // namespace

void SimulatedSource::add(const std::string& tool, ToolRole role,
                          std::unique_ptr<PoseStream> poses) {
  streams_.push_back({tool, StreamKind::kPoses, role});
  feeds_.emplace_back().poses = std::move(poses);
}

void SimulatedSource::add(const std::string& name, std::unique_ptr<ImageStream> images) {
  streams_.push_back({name, StreamKind::kImages, ToolRole::kOther});
  feeds_.emplace_back().images = std::move(images);
}

void SimulatedSource::add(const std::string& name, ButtonAction action,
                          std::vector<ButtonSample> changes) {
  streams_.push_back({name, StreamKind::kButtons, ToolRole::kOther, action});
  feeds_.emplace_back().changes = std::move(changes);
}

/// Fills the head of a stream.
Result<void> SimulatedSource::fill_head(std::size_t stream) {
  Feed& feed = feeds_[stream];
  if (feed.head || feed.ended) return {};
  const auto ended_or = [&](const Error& error) -> Result<void> {
    if (error.code != ErrorCode::kEndOfStream) return error;
    feed.ended = true;
    return {};
  };
  Sample sample;
  sample.stream = stream;
  sample.sequence = feed.count++;
  if (feed.poses) {
    auto pose = feed.poses->next(Timestamp::max());
    if (!pose) return ended_or(pose.error());
    sample.received = pose->received;
    sample.what = PoseSample{*std::move(pose)};
  } else if (!feed.images) {
    if (sample.sequence >= feed.changes.size()) {
      feed.ended = true;
      return {};
    }
    const ButtonSample& change = feed.changes[sample.sequence];
    sample.received = change.acquired;
    sample.what = change;
  } else {
    auto image = feed.images->next(Timestamp::max());
    if (!image) return ended_or(image.error());
    sample.received = image->received;
    sample.sequence = image->sequence;
    sample.what = *std::move(image);
  }
  feed.head = std::move(sample);
  return {};
}

Result<Sample> SimulatedSource::next(Deadline deadline) {
  Feed* first = nullptr;
  for (std::size_t i = 0; i < feeds_.size(); ++i) {
    if (const auto ok = fill_head(i); !ok) return ok.error();
    Feed& feed = feeds_[i];
    if (feed.head && (first == nullptr || feed.head->received < first->head->received)) {
      first = &feed;
    }
  }
  if (stopped_) return Error{ErrorCode::kCancelled, "simulation: it was stopped"};
  if (first == nullptr) return Error{ErrorCode::kEndOfStream, "simulation: no more samples"};
  const Timestamp arrives = first->head->received;
  if (wait_) wait_(std::min(arrives, deadline));
  if (stopped_) return Error{ErrorCode::kCancelled, "simulation: it was stopped"};
  if (arrives > deadline) {
    return Error{ErrorCode::kTimeout, "simulation: nothing more by the deadline"};
  }
  Sample sample = *std::move(first->head);
  first->head.reset();
  return sample;
}

std::unique_ptr<SimulatedSource> source_of(const SimulatedSession& session,
                                           std::function<void(Timestamp)> wait) {
  auto source = std::make_unique<SimulatedSource>(std::move(wait));
  source->add("Probe", ToolRole::kProbe, session.probe_poses());
  source->add("Reference", ToolRole::kReference, session.reference_poses());
  if (session.needle()) {
    source->add("Needle", ToolRole::kNeedle,
                std::make_unique<TipPoses>(session.needle_poses(),
                                           session.needle()->hub_from_needle().matrix()));
  }
  source->add("Image", session.frames());
  return source;
}

}  // namespace nav::sim
