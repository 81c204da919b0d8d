// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "app/options/session_config.hpp"
#include "io/json.hpp"
#include "session/live_session.hpp"
#include "session/session_recorder.hpp"

namespace nav::app {

/// The devices of a live session, as reports give them: docs/json.md.
io::Json json_of(const std::vector<session::DeviceStatus>& devices);

/// Buttons that were pressed, as reports give them.
io::Json json_of(const std::vector<session::PressedButton>& presses,
                 const std::vector<session::DeviceStatus>& devices);

/// Null: nothing is recorded.
io::Json json_of(const session::SessionRecorder* recorder);

/// Starts the recording of a live session, with its setup, session file and calibration. Errors
/// name the file.
Result<std::unique_ptr<session::SessionRecorder>> start_recording(const SessionConfig& config,
                                                                  const Clock& clock,
                                                                  Diagnostics& diagnostics);
/// Describes the session to its recording, before the first sample.
Result<void> describe(const SessionConfig& config, const session::LiveSession& live,
                      session::SessionRecorder& recorder);

/// True when every sample of every stream is accounted for.
bool balanced(const std::vector<session::DeviceStatus>& devices);

/// One line for each device and stream: "tracker (ndi): streaming" and "  Probe: 50.0 per second,
/// …".
std::string text_of(const std::vector<session::DeviceStatus>& devices);

/// First device of which a stream has delivered nothing, as an error of exit code 4; else ok.
Result<void> check_all_deliver(const std::vector<session::DeviceStatus>& devices);

}  // namespace nav::app
