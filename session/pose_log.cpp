// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/pose_log.hpp"

#include <array>
#include <charconv>

namespace nav::session {

std::string shortest_text(double value) {
  std::array<char, 40> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value + 0.0);
  return {digits.data(), end.ptr};
}

std::string pose_columns(const Eigen::Vector3d& translation_mm,
                         const Eigen::Quaterniond& rotation) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) text += ',' + shortest_text(translation_mm[axis]);
  // One sign for the two quaternions of a rotation.
  const double sign = rotation.w() < 0 ? -1 : 1;
  for (const double q : {rotation.x(), rotation.y(), rotation.z(), rotation.w()}) {
    text += ',' + shortest_text(sign * q);
  }
  return text;
}

PoseLog::PoseLog()
    : text_(
          "sequence,acquired_ns,received_ns,outcome,pose_gap_ns,tx_mm,ty_mm,tz_mm,qx,qy,qz,qw\n") {}

void PoseLog::add(const tracking::PairedImage& frame) {
  text_ += std::to_string(frame.sequence) + ',';
  if (!frame.tracked) {
    text_ += ",," + frame.cause + ",,,,,,,,\n";
    return;
  }
  const TrackedImage& tracked = *frame.tracked;
  text_ += std::to_string(tracked.frame.acquired.time_since_epoch().count()) + ',' +
           std::to_string(tracked.frame.received.time_since_epoch().count()) + ',' +
           (!tracked.doubt.empty() ? "degraded," : "paired,") +
           std::to_string(tracked.pose_gap.count());
  const auto& pose = tracked.reference_from_image;
  text_ += pose_columns(pose.translation_mm(), pose.rotation()) + '\n';
}

void PoseLog::add_missing(std::uint64_t sequence, const std::string& cause) {
  text_ += std::to_string(sequence) + ",,," + cause + ",,,,,,,,\n";
}

}  // namespace nav::session
