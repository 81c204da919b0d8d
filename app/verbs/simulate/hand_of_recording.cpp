// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/simulate/hand_of_recording.hpp"

#include <vector>

#include "session/recorded_session.hpp"

namespace nav::app {
namespace {

/// Pose of the middle of an image's upper edge, axes as the image.
Transform<frames::Reference, frames::Image> face_pose(const TrackedImage& tracked) {
  const int width = tracked.frame.pixels.width();
  const Point<frames::Image> middle = tracked.frame.grid.at(0.5 * (width - 1), 0);
  const auto& pose = tracked.reference_from_image;
  return {pose.rotation(), (pose * middle).mm};
}

}  // namespace

Result<std::shared_ptr<const sim::RecordedHand>> hand_of_recording(
    const std::filesystem::path& recording, const std::filesystem::path& config, Console& console) {
  session::SourceOptions source;
  source.recording = recording;
  source.plus_config = config;
  source.skip_bad_frames = true;
  auto session = session::RecordedSession::open(source, console);
  if (!session) return session.error();
  std::vector<sim::RecordedHand::Pose> poses;
  const auto played = session->play([&](const tracking::PairedImage& paired) {
    if (!paired.tracked) return;
    const Timestamp time = paired.tracked->frame.acquired;
    if (!poses.empty() && time <= poses.back().time) return;
    poses.push_back({time, face_pose(*paired.tracked)});
  });
  if (!played) return played.error();
  if (poses.empty()) return session::nothing_paired(*session);
  auto hand = sim::RecordedHand::create(poses);
  if (!hand) {
    return Error{hand.error().code, recording.string() + ": " + hand.error().message};
  }
  return std::make_shared<const sim::RecordedHand>(std::move(*hand));
}

}  // namespace nav::app
