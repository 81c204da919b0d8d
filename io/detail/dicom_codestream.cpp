// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/dicom_codestream.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace nav::io::detail {
namespace {

enum class Codestream { kOther, kJpeg2000, kJpegLs };

Codestream codestream_of(const std::string& transfer_syntax) {
  constexpr std::string_view kBegin = "1.2.840.10008.1.2.4.";
  if (!transfer_syntax.starts_with(kBegin)) return Codestream::kOther;
  const std::string_view end = std::string_view(transfer_syntax).substr(kBegin.size());
  if (end == "80" || end == "81") return Codestream::kJpegLs;
  constexpr std::array<std::string_view, 7> kJpeg2000{"90", "91", "92", "93", "201", "202", "203"};
  return std::ranges::find(kJpeg2000, end) != kJpeg2000.end() ? Codestream::kJpeg2000
                                                              : Codestream::kOther;
}

std::uint64_t big_endian(std::span<const std::byte> bytes) {
  std::uint64_t value = 0;
  for (const std::byte byte : bytes) value = value << 8 | std::to_integer<std::uint64_t>(byte);
  return value;
}

std::uint64_t little_endian(std::span<const std::byte> bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i > 0; --i) {
    value = value << 8 | std::to_integer<std::uint64_t>(bytes[i - 1]);
  }
  return value;
}

struct Size {
  std::uint64_t columns = 0, rows = 0;
};

/// The size in a SIZ segment, which follows the start of a codestream.
std::optional<Size> jpeg_2000_size(std::span<const std::byte> stream) {
  constexpr std::size_t kSiz = 2;  // Behind the marker SOC.
  constexpr std::size_t kNeeded = kSiz + 2 + 2 + 2 + 16;
  if (stream.size() < kNeeded || big_endian(stream.first(4)) != 0xff4fff51U) return std::nullopt;
  const auto number = [&](std::size_t i) {
    return big_endian(stream.subspan(kSiz + 6 + 4 * i, 4));
  };
  if (number(0) < number(2) || number(1) < number(3)) return std::nullopt;
  return Size{number(0) - number(2), number(1) - number(3)};
}

/// The size in the frame header (SOF55) of JPEG-LS, behind other segments.
std::optional<Size> jpeg_ls_size(std::span<const std::byte> stream) {
  if (stream.size() < 4 || big_endian(stream.first(2)) != 0xffd8U) return std::nullopt;
  for (std::size_t at = 2; at + 9 <= stream.size();) {
    const std::uint64_t marker = big_endian(stream.subspan(at, 2));
    const std::uint64_t length = big_endian(stream.subspan(at + 2, 2));
    if (marker == 0xfff7U) {
      return Size{big_endian(stream.subspan(at + 7, 2)), big_endian(stream.subspan(at + 5, 2))};
    }
    if (marker < 0xffc0U || marker == 0xffdaU || length < 2) return std::nullopt;
    at += 2 + length;
  }
  return std::nullopt;
}

/// The beginning of the first fragment: behind the offset table, both as items.
std::vector<std::byte> first_fragment(const InputFile& file, const ClaimedImages& claimed) {
  constexpr std::size_t kItem = 8;
  constexpr std::size_t kMost = 4096;
  std::vector<std::byte> bytes(kItem);
  if (!file.read_at(claimed.pixel_data, bytes)) return {};
  const auto table = static_cast<std::int64_t>(little_endian(std::span(bytes).subspan(4, 4)));
  const std::int64_t item = claimed.pixel_data + static_cast<std::int64_t>(kItem) + table;
  if (!file.read_at(item, bytes)) return {};
  const std::uint64_t length = little_endian(std::span(bytes).subspan(4, 4));
  bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(length, kMost)));
  const auto got = file.read_at(item + static_cast<std::int64_t>(kItem), bytes);
  bytes.resize(got ? *got : 0);
  return bytes;
}

/// True if the last fragment lacks the marker of its end, without which it was cut short. What
/// follows the pixel data may hide their end; then nothing is said.
bool lacks_end(const InputFile& file, const ClaimedImages& claimed) {
  constexpr std::int64_t kMost = 1 << 16;
  constexpr std::string_view kDelimiter("\xfe\xff\xdd\xe0\0\0\0\0", 8);
  const std::int64_t length = std::min(claimed.bytes, kMost);
  std::string tail(static_cast<std::size_t>(length), '\0');
  const auto got = file.read_at(claimed.pixel_data + claimed.bytes - length,
                                std::as_writable_bytes(std::span(tail)));
  if (!got) return false;
  tail.resize(*got);
  const auto delimiter = tail.rfind(kDelimiter);
  if (delimiter == std::string::npos) return false;
  tail.resize(delimiter);
  // A byte may pad it to an even length.
  if (tail.ends_with('\0')) tail.pop_back();
  return !tail.ends_with("\xff\xd9");
}

}  // namespace

std::string codestream_defect(const InputFile& file, const ClaimedImages& claimed) {
  const Codestream coding = codestream_of(claimed.transfer_syntax);
  if (coding == Codestream::kOther) return {};
  const auto stream = first_fragment(file, claimed);
  const bool jpeg_ls = coding == Codestream::kJpegLs;
  const auto size = jpeg_ls ? jpeg_ls_size(stream) : jpeg_2000_size(stream);
  const std::string name = jpeg_ls ? "JPEG-LS" : "JPEG 2000";
  if (!size) return "expected the size of the image in its " + name + " data, found none";
  if (size->columns != static_cast<std::uint64_t>(claimed.columns) ||
      size->rows != static_cast<std::uint64_t>(claimed.rows)) {
    return "expected " + std::to_string(claimed.columns) + " x " + std::to_string(claimed.rows) +
           " pixels (Columns, Rows), found " + std::to_string(size->columns) + " x " +
           std::to_string(size->rows) + " in the " + name + " data";
  }
  if (lacks_end(file, claimed)) {
    return name + " data cut short: expected the marker of their end, found none";
  }
  const std::int64_t lines = std::int64_t{claimed.rows} * claimed.frames;
  if (jpeg_ls) {
    constexpr std::int64_t kLinesPerByte = 8;
    if (lines <= kLinesPerByte * claimed.bytes) return {};
    return "pixel data cut short: expected a bit at least for each of " + std::to_string(lines) +
           " lines of JPEG-LS data, found " + std::to_string(claimed.bytes) + " bytes";
  }
  // A blank image takes nearly nothing; what is larger than a slice of a CT has content.
  constexpr std::int64_t kMostBlank = 8 << 20;
  constexpr std::int64_t kMostExpansionOfContent = 5000;
  const std::int64_t frame = std::int64_t{claimed.rows} * claimed.columns * claimed.bytes_of_sample;
  const std::int64_t of_frame = claimed.bytes / claimed.frames;
  if (frame <= kMostBlank + kMostExpansionOfContent * of_frame) return {};
  return "pixel data cut short: expected at least a " + std::to_string(kMostExpansionOfContent) +
         "th of " + std::to_string(frame) + " bytes for an image of JPEG 2000, found " +
         std::to_string(of_frame);
}

}  // namespace nav::io::detail
