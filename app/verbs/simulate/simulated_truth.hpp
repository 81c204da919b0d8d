// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/report.hpp"
#include "app/verbs/simulate/simulated_recording.hpp"

namespace nav::app {

/// Everything that was true of a simulated recording; the keys are documented in docs/simulate.md.
io::Json truth_of(const sim::SimulatedSession& session, const SimulatedRecording& recording);

}  // namespace nav::app
