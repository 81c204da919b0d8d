// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace nav::devices {

/// Why bytes are no usable reply.
enum class NdiFault {
  kCrc,        ///< The check of the reply or of its header does not hold.
  kGarbage,    ///< Bytes that cannot begin a reply.
  kTooLarge,   ///< Longer than kNdiMostReply.
  kTruncated,  ///< The rest did not come.
  kLayout,     ///< Intact, but its content does not have the form that the command asks for.
};
inline constexpr std::size_t kNdiFaults = 5;
/// Stable lower-case name, for reports.
const char* to_string(NdiFault fault);

/// Longest reply that is read, bytes.
inline constexpr std::size_t kNdiMostReply = std::size_t{1} << 20;

enum class NdiReplyKind { kOkay, kError, kWarning, kReset, kText, kBinary };

/// One intact reply. It points into the bytes that it was read from.
struct NdiReply {
  NdiReplyKind kind = NdiReplyKind::kText;
  std::uint8_t code = 0;              ///< kError, kWarning; 0: a warning without a number.
  std::string_view text{};            ///< Everything but kBinary: without CRC and CR.
  std::span<const std::byte> body{};  ///< kBinary: between the header and the last CRC.
};

/// Outcome of looking for one reply at the beginning of bytes.
struct NdiFraming {
  std::size_t size = 0;             ///< Bytes of the reply or of the fault; 0: more are needed.
  std::optional<NdiFault> fault{};  ///< Absent with size > 0: `reply` holds one.
  NdiReply reply{};
};

/// Reads the reply at the beginning of bytes: text up to CR with its CRC as four digits, or binary
/// with the start C4 A5 (16-bit length) or C8 A5 (32-bit length).
NdiFraming frame_ndi_reply(std::span<const std::byte> bytes);

}  // namespace nav::devices
