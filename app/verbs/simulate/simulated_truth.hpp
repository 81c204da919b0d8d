// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/report.hpp"
#include "app/verbs/simulate/simulated_recording.hpp"

namespace nav::app {

/// JSON with the truth of a simulated recording; docs/simulator.md documents the keys.
io::Json truth_of(const sim::SimulatedSession& session, const SimulatedRecording& recording);

}  // namespace nav::app
