// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace nav::devices {

/// CRC-64 of OpenIGTLink, continued from \p before: ECMA-182, polynomial 0x42F0E1EBA9EA3693, start
/// 0, not reflected, no final XOR. The CRC of "123456789" is 0x6C40DF5F0B497347. Thread-safe.
std::uint64_t igtl_crc64(std::span<const std::byte> bytes, std::uint64_t before = 0);

}  // namespace nav::devices
