// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace nav::devices {

/// CRC-16/ARC of the NDI combined API: polynomial X^16 + X^15 + X^2 + 1 reflected, start 0.
std::uint16_t ndi_crc(std::span<const std::byte> bytes);
std::uint16_t ndi_crc(std::string_view text);

}  // namespace nav::devices
