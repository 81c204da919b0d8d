// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/pose.hpp"

namespace nav {

const char* to_string(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kOk:
      return "ok";
    case TrackingStatus::kUnknown:
      return "unknown";
    case TrackingStatus::kOccluded:
      return "occluded";
    case TrackingStatus::kOutOfVolume:
      return "out_of_volume";
    case TrackingStatus::kTimeout:
      return "timeout";
    case TrackingStatus::kInvalid:
      return "invalid";
  }
  return "invalid";
}

std::string sentence(PoseDoubt doubt, const std::string& body) {
  switch (doubt) {
    case PoseDoubt::kNone:
      return "";
    case PoseDoubt::kNoStatus:
      return "the tracker gave no status for " + body;
    case PoseDoubt::kClock:
      return "the times of the poses of " + body +
             " are unsure: the clock of the tracker drifts, was set, or is not known well yet";
    case PoseDoubt::kOnly:
      return "only one pose of " + body + " has come so far";
    case PoseDoubt::kStuck:
      return "the pose of " + body + " does not change to the last digit";
    case PoseDoubt::kMoved:
      return body + " was moved: register again";
  }
  return "";
}

}  // namespace nav
