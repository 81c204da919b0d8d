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

}  // namespace nav
