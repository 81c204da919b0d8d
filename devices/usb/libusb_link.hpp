// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "devices/usb/usb_link.hpp"

namespace nav::devices {

/// Opens a device of this machine by libusb, with its first interface. A driver of the kernel that
/// has it is detached meanwhile. There is no thread: libusb's descriptors are watched through one
/// epoll descriptor, and attend() handles its events. Errors name the device and say what to do:
/// kNotFound where it is not there; kUnavailable for denied permission, another program, or several
/// devices of equal numbers.
Result<std::unique_ptr<UsbLink>> open_usb(const UsbId& id);

}  // namespace nav::devices
