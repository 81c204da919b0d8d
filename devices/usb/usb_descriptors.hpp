// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "devices/usb/usb_emulated_device.hpp"

namespace nav::devices {

/// A descriptor of a device of high speed (USB 2.0, 9.6). \p kind: value of the request, the type
/// in its upper byte: device (1), configuration with all below it (2), string (3) or qualifier (6).
/// Absent for others.
std::optional<std::vector<std::byte>> usb_descriptor(const UsbDescription& device,
                                                     std::uint16_t kind);

}  // namespace nav::devices
