// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "devices/usb/usb_link.hpp"

namespace nav::devices {

/// Opens a device of another machine, or an emulated one, that a USB/IP server exports: usbipd of
/// Linux, or UsbipServer. It needs no USB in this machine. Returns at once: the link asks the
/// server for its devices and imports the first with these numbers while attend() is called; what
/// is queued before goes out then. A server without the device is kGone with a failure(). USB/IP
/// has no passwords and no encryption: for a network that is trusted. Errors: those of
/// resolve_tcp() and begin_tcp_connect().
Result<std::unique_ptr<UsbLink>> open_usbip(const std::string& host, std::uint16_t port,
                                            const UsbId& id);

}  // namespace nav::devices
