// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nav::sim {

/// A source of SimulatedSession, for listings.
struct SimulatedDevice {
  std::string name;         ///< As tracker_kind_from() or probe_model_from() knows it.
  std::string kind;         ///< "tracker" or "probe".
  std::string description;  ///< One line.
};

/// Every simulated tracker and probe: sources of poses and pictures on the session clock, virtual
/// or, by PacedSource, in real time.
const std::vector<SimulatedDevice>& simulated_devices();

}  // namespace nav::sim
