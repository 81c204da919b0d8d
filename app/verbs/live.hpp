// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Shows the live plane of the devices of a session file inside a CT, in a window or as images in a
/// folder. Ends after config.output.seconds, with Ctrl-C, when the window is closed, or when no
/// device has anything more. kUnavailable, after writing, when a device has delivered nothing.
Result<void> run_live(const SessionConfig& config, const std::optional<std::string>& json,
                      Console& console);

/// Names of the files that it writes into the folder, without the images.
std::vector<std::string> live_outputs();

}  // namespace nav::app
