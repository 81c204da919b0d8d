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

enum class NodeKind { kSerial, kVideo, kInput };
/// "serial", "video", "input".
const char* to_string(NodeKind kind);

/// A device file of the kernel.
struct DeviceNode {
  NodeKind kind = NodeKind::kSerial;
  std::filesystem::path path;  ///< Such as "/dev/ttyUSB0".
  std::string name;            ///< Name that the kernel gives, or that of the driver.
  std::string trouble;         ///< Why it cannot be opened for reading; empty: it can.
};

/// Serial ports with hardware behind them, video devices and input devices (keyboards, foot
/// switches), by kind and path. A class that the kernel lacks has none.
std::vector<DeviceNode> list_nodes(const std::filesystem::path& sys_class = "/sys/class",
                                   const std::filesystem::path& dev = "/dev");

}  // namespace nav::devices
