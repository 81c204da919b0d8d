// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "app/console.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Lists the USB devices and CAN interfaces that the kernel shows, and the simulated trackers and
/// probes with the command that starts each.
Result<void> run_devices(const std::optional<std::string>& json, Console& console);

}  // namespace nav::app
