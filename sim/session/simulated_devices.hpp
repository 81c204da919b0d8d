// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nav::sim {

/// Source of SimulatedSession, for listings.
struct SimulatedDevice {
  std::string name;         ///< Name for tracker_kind_from() or probe_model_from().
  std::string kind;         ///< "tracker" or "probe".
  std::string description;  ///< Description in one line.
};

/// All simulated trackers and probes: sources of poses and images on the session clock, which is
/// virtual or, with PacedSource, real time.
const std::vector<SimulatedDevice>& simulated_devices();

}  // namespace nav::sim
