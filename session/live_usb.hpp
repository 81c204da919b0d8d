// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "session/live_devices.hpp"

namespace nav::session {

/// True for the kinds "polhemus" and "interson".
bool is_usb_device(const DeviceOptions& device);

/// Rejects an address, a station, a setting or a shape that the kind cannot have. \p name: of
/// the device in messages, "devices[0]".
Result<void> validate_usb(const DeviceOptions& device, const std::string& name);

/// Opens a device on USB; needle_body and source as open_device(). Precondition: validate_usb().
Result<LiveDevice> open_usb_device(const DeviceOptions& device, const std::string& needle_body,
                                   const SourceOptions& source, const Clock& clock,
                                   Diagnostics& diagnostics);

}  // namespace nav::session
