// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_crc.hpp"

#include <array>
#include <bit>
#include <cstring>

namespace nav::devices {
namespace {

constexpr std::uint64_t kCrcPolynomial = 0x42F0E1EBA9EA3693u;
/// Bytes that one step takes. The tables have 32 kB, which is what the first cache holds.
constexpr std::size_t kCrcSlice = 16;

using CrcTables = std::array<std::array<std::uint64_t, 256>, kCrcSlice>;

/// Table i holds the CRC of one byte that i zeros follow.
constexpr CrcTables make_crc_tables() {
  CrcTables tables{};
  for (std::size_t value = 0; value < 256; ++value) {
    std::uint64_t crc = static_cast<std::uint64_t>(value) << 56;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 63) != 0 ? (crc << 1) ^ kCrcPolynomial : crc << 1;
    }
    tables[0][value] = crc;
  }
  for (std::size_t i = 1; i < kCrcSlice; ++i) {
    for (std::size_t value = 0; value < 256; ++value) {
      const std::uint64_t crc = tables[i - 1][value];
      tables[i][value] = (crc << 8) ^ tables[0][crc >> 56];
    }
  }
  return tables;
}

alignas(64) constexpr CrcTables kCrcTables = make_crc_tables();

std::uint64_t load_big_endian_64(const std::byte* at) {
  std::uint64_t value = 0;
  std::memcpy(&value, at, sizeof value);
  return std::endian::native == std::endian::little ? __builtin_bswap64(value) : value;
}

/// CRC contribution of eight bytes that \p zeros bytes follow.
template <std::size_t zeros>
std::uint64_t crc_of_eight(std::uint64_t word) {
  return kCrcTables[zeros + 7][word >> 56] ^ kCrcTables[zeros + 6][word >> 48 & 255] ^
         kCrcTables[zeros + 5][word >> 40 & 255] ^ kCrcTables[zeros + 4][word >> 32 & 255] ^
         kCrcTables[zeros + 3][word >> 24 & 255] ^ kCrcTables[zeros + 2][word >> 16 & 255] ^
         kCrcTables[zeros + 1][word >> 8 & 255] ^ kCrcTables[zeros][word & 255];
}

}  // namespace

std::uint64_t igtl_crc64(std::span<const std::byte> bytes, std::uint64_t before) {
  std::uint64_t crc = before;
  const std::byte* at = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= kCrcSlice; left -= kCrcSlice, at += kCrcSlice) {
    crc =
        crc_of_eight<8>(crc ^ load_big_endian_64(at)) ^ crc_of_eight<0>(load_big_endian_64(at + 8));
  }
  for (; left > 0; --left, ++at) {
    crc = (crc << 8) ^ kCrcTables[0][(crc >> 56) ^ std::to_integer<std::uint64_t>(*at)];
  }
  return crc;
}

}  // namespace nav::devices
