// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/faulty_source.hpp"

#include <cmath>

namespace nav::app {

Result<Sample> FaultySource::next(Deadline deadline) {
  for (;;) {
    auto sample = source_->next(deadline);
    if (!sample) return sample;
    if (std::holds_alternative<UltrasoundImage>(sample->what) && holds(held_until_)) continue;
    auto* pose = std::get_if<PoseSample>(&sample->what);
    if (pose == nullptr || !holds(covered_until_)) return sample;
    if (streams()[sample->stream].role == ToolRole::kReference) return sample;
    pose->pose.status = TrackingStatus::kOccluded;
    pose->pose.tracker_from_body = Eigen::Matrix4d::Constant(std::nan(""));
    return sample;
  }
}

}  // namespace nav::app
