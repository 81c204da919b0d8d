// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/pose_log.hpp"

#include <array>
#include <charconv>

namespace nav::app {
namespace {

void append(std::string& text, double value) {
  std::array<char, 40> digits{};
  // -0 and 0 are the same pose.
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value + 0.0);
  text.append(digits.data(), end.ptr);
}

}  // namespace

PoseLog::PoseLog()
    : text_(
          "sequence,acquired_ns,received_ns,outcome,pose_gap_ns,tx_mm,ty_mm,tz_mm,qx,qy,qz,qw\n") {}

void PoseLog::add(const tracking::PairedFrame& frame) {
  text_ += std::to_string(frame.sequence) + ',';
  if (!frame.tracked) {
    text_ += ",," + frame.cause + ",,,,,,,,\n";
    return;
  }
  const TrackedFrame& tracked = *frame.tracked;
  text_ += std::to_string(tracked.frame.acquired.time_since_epoch().count()) + ',' +
           std::to_string(tracked.frame.received.time_since_epoch().count()) + ',' +
           (tracked.degraded ? "degraded," : "paired,") + std::to_string(tracked.pose_gap.count());
  const auto& pose = tracked.reference_from_image;
  for (int axis = 0; axis < 3; ++axis) {
    text_ += ',';
    append(text_, pose.translation_mm()[axis]);
  }
  // One sign for the two quaternions of a rotation.
  const double sign = pose.rotation().w() < 0 ? -1 : 1;
  for (const double q :
       {pose.rotation().x(), pose.rotation().y(), pose.rotation().z(), pose.rotation().w()}) {
    text_ += ',';
    append(text_, sign * q);
  }
  text_ += '\n';
}

void PoseLog::add_missing(std::uint64_t sequence, const std::string& cause) {
  text_ += std::to_string(sequence) + ",,," + cause + ",,,,,,,,\n";
}

}  // namespace nav::app
