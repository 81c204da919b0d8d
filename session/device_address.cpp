// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/device_address.hpp"

#include <charconv>
#include <utility>

namespace nav::session {

namespace {

/// "host:port" after a beginning.
std::optional<TcpAddress> address_after(std::string_view begin, std::string_view text) {
  if (!text.starts_with(begin)) return std::nullopt;
  text.remove_prefix(begin.size());
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  TcpAddress address{std::string(host)};
  const auto read = std::from_chars(port.data(), port.data() + port.size(), address.port);
  const bool whole = read.ec == std::errc() && read.ptr == port.data() + port.size();
  if (!whole || address.port == 0 || host.empty()) return std::nullopt;
  return address;
}

/// Two numbers of four hexadecimal digits, "05f3:00ff".
std::optional<HidAddress> two_numbers(std::string_view text) {
  constexpr std::size_t kDigits = 4;
  if (text.size() != 2 * kDigits + 1 || text[kDigits] != ':') return std::nullopt;
  const auto number = [](std::string_view digits) -> std::optional<std::uint16_t> {
    std::uint16_t value = 0;
    const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
    if (read.ec != std::errc() || read.ptr != digits.data() + digits.size()) return std::nullopt;
    return value;
  };
  const auto vendor = number(text.substr(0, kDigits));
  const auto product = number(text.substr(kDigits + 1));
  if (!vendor || !product) return std::nullopt;
  return HidAddress{*vendor, *product};
}

}  // namespace

std::optional<TcpAddress> tcp_address(std::string_view text) { return address_after("tcp:", text); }

std::optional<TcpAddress> usbip_address(std::string_view text) {
  return address_after("usbip:", text);
}

std::optional<std::string> serial_address(std::string_view text) {
  constexpr std::string_view kBegin = "serial:";
  if (!text.starts_with(kBegin) || text.size() == kBegin.size()) return std::nullopt;
  return std::string(text.substr(kBegin.size()));
}

std::optional<std::string> can_address(std::string_view text) {
  constexpr std::string_view kBegin = "can:";
  constexpr std::size_t kLongestName = 15;  // IFNAMSIZ of an interface without its end.
  if (!text.starts_with(kBegin)) return std::nullopt;
  text.remove_prefix(kBegin.size());
  if (text.empty() || text.size() > kLongestName) return std::nullopt;
  return std::string(text);
}

std::optional<HidAddress> hid_address(std::string_view text) {
  constexpr std::string_view kBegin = "hid:";
  if (!text.starts_with(kBegin)) return std::nullopt;
  return two_numbers(text.substr(kBegin.size()));
}

std::optional<UsbAddress> usb_address(std::string_view text) {
  constexpr std::string_view kBegin = "usb:";
  constexpr std::size_t kNumbers = 9;
  if (!text.starts_with(kBegin)) return std::nullopt;
  text.remove_prefix(kBegin.size());
  const auto numbers = two_numbers(text.substr(0, kNumbers));
  if (!numbers) return std::nullopt;
  UsbAddress address{numbers->vendor, numbers->product};
  text.remove_prefix(kNumbers);
  if (text.empty()) return address;
  if (text.front() != ':' || text.size() == 1) return std::nullopt;
  address.serial = text.substr(1);
  return address;
}

std::optional<CameraAddress> camera_address(std::string_view text) {
  for (const auto& [begin, is_device] : {std::pair<std::string_view, bool>{"v4l2:", true},
                                         std::pair<std::string_view, bool>{"film:", false}}) {
    if (text.starts_with(begin) && text.size() > begin.size()) {
      return CameraAddress{std::string(text.substr(begin.size())), is_device};
    }
  }
  return std::nullopt;
}

std::optional<std::string> input_address(std::string_view text) {
  constexpr std::string_view kBegin = "input:";
  if (!text.starts_with(kBegin) || text.size() == kBegin.size()) return std::nullopt;
  return std::string(text.substr(kBegin.size()));
}

}  // namespace nav::session
