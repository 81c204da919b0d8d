// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Lists the USB devices and CAN interfaces that the kernel shows, and the simulated trackers and
/// probes with the command that starts each.
Result<void> run_devices(const std::optional<std::string>& json, Console& console);

/// Starts the devices of a session file and says what comes from each, for config.output.seconds
/// (0: 5 s) or until Ctrl-C, and records it if config.output.record says so (0: until Ctrl-C).
/// kUnavailable, after the report, when a stream has delivered nothing.
Result<void> run_session_devices(const SessionConfig& config,
                                 const std::optional<std::string>& json, Console& console);

}  // namespace nav::app
