// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/ndi/ndi_poses.hpp"

namespace nav::devices {

/// The other direction of the codec, for the emulator and tests.

/// A text reply with its CRC and CR.
std::vector<std::byte> ndi_text_reply(std::string_view text);
/// A binary reply around a body: C4 A5, or C8 A5 for a body that does not fit its 16-bit length or
/// when \p extended says so.
std::vector<std::byte> ndi_binary_reply(std::span<const std::byte> body, bool extended = false);

/// Content of the replies to TX, BX and BX2. TX writes translations of at most 9999.99 mm, and at
/// most 9.9999 for rotation and error; what is beyond is cut to that.
std::string ndi_tx_text(const NdiReadings& readings);
std::vector<std::byte> ndi_bx_body(const NdiReadings& readings);
/// One frame with the number and time of the first reading.
std::vector<std::byte> ndi_bx2_body(const NdiReadings& readings);

}  // namespace nav::devices
