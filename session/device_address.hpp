// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace nav::session {

struct TcpAddress {
  std::string host;
  std::uint16_t port = 0;
};
/// "tcp:host:port", "tcp:[::1]:port". Absent: anything else, as below.
std::optional<TcpAddress> tcp_address(std::string_view text);

/// Path of "serial:/dev/ttyUSB0".
std::optional<std::string> serial_address(std::string_view text);

/// Interface of "can:can0".
std::optional<std::string> can_address(std::string_view text);

/// Numbers of vendor and product of "hid:05f3:00ff", four hexadecimal digits each.
struct HidAddress {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
};
std::optional<HidAddress> hid_address(std::string_view text);

/// "usb:0f44:ff20", four hexadecimal digits each, or "usb:0f44:ff20:SERIAL".
struct UsbAddress {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string serial{};  ///< Empty: any.
};
std::optional<UsbAddress> usb_address(std::string_view text);

/// "usbip:host:port" or "usbip:[::1]:3240": a device that a USB/IP server exports.
std::optional<TcpAddress> usbip_address(std::string_view text);

/// "v4l2:/dev/video0", or "film:FILE": a film, or numbered images such as "film:frame_%03d.png".
struct CameraAddress {
  std::string path;
  bool is_device = true;
};
std::optional<CameraAddress> camera_address(std::string_view text);

/// Path of "input:/dev/input/event3".
std::optional<std::string> input_address(std::string_view text);

}  // namespace nav::session
