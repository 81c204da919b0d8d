// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace nav::io::mcap {

/// CRC-32 (ISO 3309, the checksum of zlib and MCAP) of the bytes. \p before: the checksum of the
/// bytes that precede them.
std::uint32_t crc32_of(std::span<const std::byte> bytes, std::uint32_t before = 0);
/// CRC-32 of two stretches, one after the other, from the checksums of both and the length of the
/// second, bytes.
std::uint32_t crc32_joined(std::uint32_t first, std::uint32_t second, std::uint64_t second_bytes);

}  // namespace nav::io::mcap
