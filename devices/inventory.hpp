// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::devices {

struct UsbDevice {
  int bus;
  int address;
  std::uint16_t vendor_id;
  std::uint16_t product_id;
  std::string product;  ///< Name that the device reports; empty when it may not be opened.
};

/// USB devices found by libusb, sorted by bus and address. kUnavailable without a USB stack.
Result<std::vector<UsbDevice>> list_usb();

struct CanInterface {
  std::string name;  ///< Such as "can0" or "vcan0".
  bool up;
};

/// Network interfaces of hardware type CAN (ARPHRD_CAN), by name, from sysfs.
Result<std::vector<CanInterface>> list_can(
    const std::filesystem::path& sys_class_net = "/sys/class/net");

}  // namespace nav::devices
