// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "session/navigator.hpp"
#include "sim/simulated_tracker.hpp"

namespace nav::app {

/// Merges all streams of a simulated procedure into one, in order of arrival.
class SimulatedEvents {
 public:
  /// The procedure must outlive the events.
  explicit SimulatedEvents(const sim::Procedure& procedure);
  /// Returns the next event that has arrived by the deadline, if any.
  std::optional<session::SessionEvent> next(Deadline deadline);
  [[nodiscard]] bool ended() const;

 private:
  sim::SimulatedTracker probe_poses_;
  sim::SimulatedTracker reference_poses_;
  sim::SimulatedTracker needle_poses_;
  sim::SimulatedProbe frames_;
};

}  // namespace nav::app
