// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "app/options/session_config.hpp"

namespace nav::app {

/// Replaces this process by sonde-window, which shows a session. It reads the session from a file
/// in memory, so that nothing stays behind. A recording is played once. json: file for the report
/// of the window; absent: none. The window also records into output.record, and closes after
/// output.seconds. Returns only if it fails: kUnavailable without sonde-window, or the
/// error of a session that no file can hold.
Result<void> show_in_window(const SessionConfig& config, const std::optional<std::string>& json);

}  // namespace nav::app
