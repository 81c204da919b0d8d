// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/json.hpp"
#include "session/live_session.hpp"

namespace nav::app {

/// The devices of a live session, as reports give them: docs/json.md.
io::Json json_of(const std::vector<session::DeviceStatus>& devices);

/// True when every sample of every stream is accounted for.
bool balanced(const std::vector<session::DeviceStatus>& devices);

/// One line for each device and stream: "tracker (ndi): streaming" and "  Probe: 50.0 per second,
/// …".
std::string text_of(const std::vector<session::DeviceStatus>& devices);

/// First device of which a stream has delivered nothing, as an error of exit code 4; else ok.
Result<void> check_all_deliver(const std::vector<session::DeviceStatus>& devices);

}  // namespace nav::app
