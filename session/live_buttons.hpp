// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "session/live_devices.hpp"

namespace nav::session {

/// True for the kinds "footswitch" and "can-buttons".
bool is_button_device(const DeviceOptions& device);

/// Changes of a simulated button: down at each of its times, and up 0.2 s later.
std::vector<ButtonSample> simulated_changes(const DeviceButton& button);

/// Rejects an address, a key, a frame, a time or an action that the kind cannot have. \p name: of
/// the device in messages, "devices[0]".
Result<void> validate_buttons(const DeviceOptions& device, const std::string& name);

/// Opens a device of buttons. Precondition: validate_buttons().
Result<LiveDevice> open_buttons(const DeviceOptions& device, const Clock& clock,
                                Diagnostics& diagnostics);

}  // namespace nav::session
