// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_reply.hpp"

#include <algorithm>

#include "devices/ndi/ndi_crc.hpp"
#include "devices/ndi/ndi_hex.hpp"

namespace nav::devices {
namespace {

constexpr std::size_t kCrcDigits = 4;
constexpr std::size_t kCrcBytes = 2;

std::uint32_t little_endian(std::span<const std::byte> bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) {
    value = (value << 8) | std::to_integer<std::uint32_t>(bytes[i]);
  }
  return value;
}

NdiFraming faulty(std::size_t size, NdiFault fault) { return {.size = size, .fault = fault}; }

bool is_text(std::byte byte) {
  const auto c = std::to_integer<unsigned>(byte);
  return (c >= 0x20 && c < 0x7F) || c == '\n';
}

/// A text without its CRC.
NdiReply read_text(std::string_view text) {
  const auto numbered = [&](std::string_view begin, NdiReplyKind kind) -> std::optional<NdiReply> {
    if (!text.starts_with(begin)) return std::nullopt;
    const auto code = ndi_from_hex<std::uint8_t>(text.substr(begin.size()));
    if (text.size() != begin.size() + 2 || !code) return std::nullopt;
    return NdiReply{.kind = kind, .code = *code, .text = text};
  };
  if (text == "OKAY") return {.kind = NdiReplyKind::kOkay, .text = text};
  if (text == "RESET") return {.kind = NdiReplyKind::kReset, .text = text};
  if (text == "WARNING") return {.kind = NdiReplyKind::kWarning, .text = text};
  if (const auto error = numbered("ERROR", NdiReplyKind::kError)) return *error;
  if (const auto warning = numbered("WARNING", NdiReplyKind::kWarning)) return *warning;
  return {.kind = NdiReplyKind::kText, .text = text};
}

NdiFraming frame_text(std::span<const std::byte> bytes) {
  const auto end = std::find_if_not(bytes.begin(), bytes.end(), is_text);
  const auto size = static_cast<std::size_t>(end - bytes.begin());
  if (size > kNdiMostReply) return faulty(size, NdiFault::kTooLarge);
  if (end == bytes.end()) return {};
  if (*end != std::byte{'\r'}) return faulty(size + 1, NdiFault::kGarbage);
  const std::string_view line(reinterpret_cast<const char*>(bytes.data()), size);
  if (size < kCrcDigits) return faulty(size + 1, NdiFault::kGarbage);
  const std::string_view text = line.substr(0, size - kCrcDigits);
  if (ndi_from_hex<std::uint16_t>(line.substr(text.size())) != ndi_crc(text)) {
    return faulty(size + 1, NdiFault::kCrc);
  }
  return {.size = size + 1, .reply = read_text(text)};
}

NdiFraming frame_binary(std::span<const std::byte> bytes, std::size_t length_bytes) {
  const std::size_t checked = 2 + length_bytes;
  const std::size_t header = checked + kCrcBytes;
  if (bytes.size() < header) return {};
  if (little_endian(bytes.subspan(checked, kCrcBytes)) != ndi_crc(bytes.first(checked))) {
    return faulty(header, NdiFault::kCrc);
  }
  const std::size_t length = little_endian(bytes.subspan(2, length_bytes));
  if (length > kNdiMostReply) return faulty(header, NdiFault::kTooLarge);
  const std::size_t size = header + length + kCrcBytes;
  if (bytes.size() < size) return {};
  const auto body = bytes.subspan(header, length);
  if (little_endian(bytes.subspan(header + length, kCrcBytes)) != ndi_crc(body)) {
    return faulty(size, NdiFault::kCrc);
  }
  return {.size = size, .reply = {.kind = NdiReplyKind::kBinary, .body = body}};
}

}  // namespace

const char* to_string(NdiFault fault) {
  switch (fault) {
    case NdiFault::kCrc:
      return "crc";
    case NdiFault::kGarbage:
      return "garbage";
    case NdiFault::kTooLarge:
      return "too_large";
    case NdiFault::kTruncated:
      return "truncated";
    case NdiFault::kLayout:
      return "layout";
  }
  return "unknown";
}

NdiFraming frame_ndi_reply(std::span<const std::byte> bytes) {
  if (bytes.empty()) return {};
  const bool short_form = bytes[0] == std::byte{0xC4};
  if (!short_form && bytes[0] != std::byte{0xC8}) return frame_text(bytes);
  if (bytes.size() < 2) return {};
  if (bytes[1] != std::byte{0xA5}) return faulty(1, NdiFault::kGarbage);
  return frame_binary(bytes, short_form ? 2 : 4);
}

}  // namespace nav::devices
