// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/usb_link.hpp"

#include <cstdio>

namespace nav::devices {

std::string usb_name(const UsbId& id) {
  char text[24];
  std::snprintf(text, sizeof text, "usb:%04x:%04x", id.vendor, id.product);
  return id.serial.empty() ? text : std::string(text) + ":" + id.serial;
}

const char* to_string(UsbEnd end) {
  switch (end) {
    case UsbEnd::kDone:
      return "done";
    case UsbEnd::kStall:
      return "stall";
    case UsbEnd::kOverflow:
      return "overflow";
    case UsbEnd::kTimeout:
      return "transfer_timeout";
    case UsbEnd::kGone:
      return "unplugged";
    case UsbEnd::kError:
      return "transfer_error";
  }
  return "unknown";
}

}  // namespace nav::devices
