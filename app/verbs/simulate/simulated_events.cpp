// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/simulate/simulated_events.hpp"

#include <algorithm>

namespace nav::app {

SimulatedEvents::SimulatedEvents(const sim::Procedure& procedure)
    : probe_poses_(procedure, sim::TrackedBody::kProbe),
      reference_poses_(procedure, sim::TrackedBody::kReference),
      needle_poses_(procedure, sim::TrackedBody::kNeedle),
      frames_(procedure) {}

std::optional<session::SessionEvent> SimulatedEvents::next(Deadline deadline) {
  // Poses come before images that arrive at the same time, so that an image finds its pose.
  const Timestamp first = std::min({probe_poses_.next_arrival(), reference_poses_.next_arrival(),
                                    needle_poses_.next_arrival(), frames_.next_arrival()});
  if (first > deadline || first == Timestamp::max()) return std::nullopt;
  const auto pose_event = [&]<class Pose>(sim::SimulatedTracker& source,
                                          Pose) -> std::optional<session::SessionEvent> {
    auto raw = source.next(deadline);
    NAV_CHECK(raw.has_value());
    return session::SessionEvent{first, Pose{*raw}};
  };
  if (first == probe_poses_.next_arrival()) return pose_event(probe_poses_, session::ProbePose{});
  if (first == reference_poses_.next_arrival()) {
    return pose_event(reference_poses_, session::ReferencePose{});
  }
  if (first == needle_poses_.next_arrival())
    return pose_event(needle_poses_, session::NeedlePose{});
  auto frame = frames_.next(deadline);
  NAV_CHECK(frame.has_value());
  return session::SessionEvent{first, std::move(*frame)};
}

bool SimulatedEvents::ended() const {
  return frames_.next_arrival() == Timestamp::max() &&
         probe_poses_.next_arrival() == Timestamp::max() &&
         reference_poses_.next_arrival() == Timestamp::max() &&
         needle_poses_.next_arrival() == Timestamp::max();
}

}  // namespace nav::app
