// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_crc.hpp"

#include <array>

namespace nav::devices {
namespace {

constexpr std::array<std::uint16_t, 256> ndi_crc_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned i = 0; i < 256; ++i) {
    unsigned value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value & 1) != 0 ? (value >> 1) ^ 0xA001 : value >> 1;
    table[i] = static_cast<std::uint16_t>(value);
  }
  return table;
}

}  // namespace

std::uint16_t ndi_crc(std::span<const std::byte> bytes) {
  static constexpr auto kTable = ndi_crc_table();
  unsigned crc = 0;
  for (const std::byte byte : bytes) {
    crc = (crc >> 8) ^ kTable[(crc ^ std::to_integer<unsigned>(byte)) & 0xFF];
  }
  return static_cast<std::uint16_t>(crc);
}

std::uint16_t ndi_crc(std::string_view text) { return ndi_crc(std::as_bytes(std::span(text))); }

}  // namespace nav::devices
