// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_encode.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "devices/ndi/ndi_crc.hpp"
#include "devices/ndi/ndi_hex.hpp"

namespace nav::devices {
namespace {

using NdiBytes = std::vector<std::byte>;

void append_number(NdiBytes& bytes, std::uint32_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    bytes.push_back(static_cast<std::byte>(value >> (8 * i)));
  }
}

void append_pose(NdiBytes& bytes, const NdiToolReading& tool) {
  const auto append = [&](double value) {
    append_number(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4);
  };
  for (const double value : tool.rotation_wxyz) append(value);
  for (const double value : tool.translation_mm) append(value);
  append(tool.error_mm);
}

std::uint32_t port_status(const NdiToolReading& tool) {
  return tool.status | (tool.out_of_volume ? 1U << 6 : 0U) |
         (tool.partly_out_of_volume ? 1U << 7 : 0U);
}

std::string fixed_digits(double value, std::size_t digits, double unit) {
  const double most = std::pow(10.0, static_cast<double>(digits)) - 1;
  const double scaled = std::min(std::round(std::abs(value) / unit), most);
  std::string text = std::to_string(static_cast<std::int64_t>(scaled));
  text.insert(0, digits - text.size(), '0');
  return (value < 0 ? "-" : "+") + text;
}

std::string tx_line(const NdiToolReading& tool) {
  std::string line = ndi_to_hex(tool.handle, 2);
  if (tool.presence == NdiPresence::kUnoccupied) return line + "UNOCCUPIED\n";
  if (tool.presence == NdiPresence::kDisabled) return line + "DISABLED\n";
  if (tool.presence == NdiPresence::kMissing) {
    line += "MISSING";
  } else {
    for (const double value : tool.rotation_wxyz) line += fixed_digits(value, 5, 1e-4);
    for (const double value : tool.translation_mm) line += fixed_digits(value, 6, 1e-2);
    line += fixed_digits(tool.error_mm, 5, 1e-4);
  }
  return line + ndi_to_hex(port_status(tool), 8) + ndi_to_hex(tool.number.value_or(0), 8) + '\n';
}

std::uint32_t bx2_status(const NdiToolReading& tool) {
  constexpr std::uint32_t kMissingBit = 1U << 8;
  if (tool.presence == NdiPresence::kUnoccupied) return kMissingBit | 33U;
  if (tool.presence == NdiPresence::kDisabled) return kMissingBit | 32U;
  if (tool.presence == NdiPresence::kMissing) return kMissingBit | 13U;
  if (tool.out_of_volume) return 9;
  return tool.partly_out_of_volume ? 3 : 0;
}

void append_bx2_component(NdiBytes& bytes, std::uint32_t type, std::size_t items,
                          const NdiBytes& content) {
  append_number(bytes, type, 2);
  append_number(bytes, static_cast<std::uint32_t>(content.size() + 12), 4);
  append_number(bytes, 0, 2);
  append_number(bytes, static_cast<std::uint32_t>(items), 4);
  bytes.insert(bytes.end(), content.begin(), content.end());
}

/// Version 1 and one component follows.
NdiBytes bx2_begin() {
  NdiBytes bytes;
  append_number(bytes, 1, 2);
  append_number(bytes, 1, 2);
  return bytes;
}

}  // namespace

NdiBytes ndi_text_reply(std::string_view text) {
  std::string line(text);
  line += ndi_to_hex(ndi_crc(text), 4) + '\r';
  const auto bytes = std::as_bytes(std::span(line));
  return {bytes.begin(), bytes.end()};
}

NdiBytes ndi_binary_reply(std::span<const std::byte> body, bool extended) {
  const bool long_form = extended || body.size() > 0xFFFF;
  NdiBytes bytes{std::byte{static_cast<unsigned char>(long_form ? 0xC8 : 0xC4)}, std::byte{0xA5}};
  append_number(bytes, static_cast<std::uint32_t>(body.size()), long_form ? 4 : 2);
  append_number(bytes, ndi_crc(bytes), 2);
  bytes.insert(bytes.end(), body.begin(), body.end());
  append_number(bytes, ndi_crc(body), 2);
  return bytes;
}

std::string ndi_tx_text(const NdiReadings& readings) {
  std::string text = ndi_to_hex(readings.tools.size(), 2);
  for (const NdiToolReading& tool : readings.tools) text += tx_line(tool);
  return text + ndi_to_hex(readings.system_status, 4);
}

NdiBytes ndi_bx_body(const NdiReadings& readings) {
  NdiBytes bytes;
  append_number(bytes, static_cast<std::uint32_t>(readings.tools.size()), 1);
  for (const NdiToolReading& tool : readings.tools) {
    append_number(bytes, tool.handle, 1);
    const bool measured = tool.presence == NdiPresence::kMeasured;
    const bool missing = tool.presence == NdiPresence::kMissing;
    append_number(bytes, measured ? 1 : missing ? 2 : 4, 1);
    if (measured) append_pose(bytes, tool);
    if (!measured && !missing) continue;
    append_number(bytes, port_status(tool), 4);
    append_number(bytes, tool.number.value_or(0), 4);
  }
  append_number(bytes, readings.system_status, 2);
  return bytes;
}

NdiBytes ndi_bx2_body(const NdiReadings& readings) {
  NdiBytes items;
  for (const NdiToolReading& tool : readings.tools) {
    append_number(items, tool.handle, 2);
    append_number(items, bx2_status(tool), 2);
    if (tool.presence == NdiPresence::kMeasured) append_pose(items, tool);
  }
  NdiBytes frame;
  const NdiToolReading first = readings.tools.empty() ? NdiToolReading{} : readings.tools[0];
  constexpr std::uint32_t kPassiveFrame = 2;
  append_number(frame, kPassiveFrame, 1);
  append_number(frame, first.number.value_or(0), 1);
  append_number(frame, 0, 2);
  const auto time = first.time.value_or(DeviceTime{}).time_since_epoch().count();
  constexpr std::int64_t kSecond = 1'000'000'000;
  append_number(frame, first.number.value_or(0), 4);
  append_number(frame, static_cast<std::uint32_t>(time / kSecond), 4);
  append_number(frame, static_cast<std::uint32_t>(time % kSecond), 4);
  const NdiBytes begin = bx2_begin();
  frame.insert(frame.end(), begin.begin(), begin.end());
  append_bx2_component(frame, 2, readings.tools.size(), items);
  NdiBytes bytes = bx2_begin();
  append_bx2_component(bytes, 1, 1, frame);
  return bytes;
}

}  // namespace nav::devices
