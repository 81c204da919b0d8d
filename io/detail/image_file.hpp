// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/pixel_type.hpp"
#include "nav/result.hpp"

namespace nav::io::detail {

enum class Encoding { kRaw, kDeflate };  ///< kDeflate: one zlib or gzip stream over everything.

/// Deflate cannot expand by more than 1032 : 1.
constexpr std::int64_t kMostExpansion = 1100;

/// Where a part of the samples lies.
struct DataPart {
  std::filesystem::path path;
  std::int64_t offset = 0;
  std::int64_t size = 0;  ///< Bytes that are there (encoded).
};

using Field = std::pair<std::string_view, std::string_view>;

/// The container-level content of a MetaImage or NRRD header: everything needed to find samples.
struct ImageFile {
  std::filesystem::path path;
  std::string format;                 ///< "MetaImage" or "NRRD".
  std::unique_ptr<std::string> text;  ///< The header; keys and values point into it.
  std::vector<Field> fields;          ///< Every key and value, trimmed, in order.
  std::map<std::string_view, std::string_view> keys;  ///< The fields outside frames.
  std::vector<std::int64_t> sizes;      ///< Samples per axis, fastest first, without components.
  std::vector<std::string_view> kinds;  ///< Per axis of sizes, or empty.
  int components = 1;
  std::size_t component_axes = 0;  ///< Axes of the file before those of sizes: 0, or 1 of an NRRD.
  PixelType type = PixelType::kUint8;
  bool big_endian = false;
  Encoding encoding = Encoding::kRaw;
  std::vector<DataPart> data;
  std::int64_t sample_bytes = 0;     ///< Of all samples, decoded.
  std::int64_t available_bytes = 0;  ///< Of data, encoded.

  /// Value of a key outside frames, or empty.
  [[nodiscard]] std::string_view value(std::string_view key) const;
  [[nodiscard]] bool has(std::string_view key) const { return keys.count(key) != 0; }
};

/// True for "Seq_Frame…" keys, which belong to one frame of a sequence.
bool is_frame_key(std::string_view key);

/// Reads a MetaImage or NRRD header by what the file begins with, and checks its claims: sizes that
/// overflow, compressed data that could not inflate to them, data files that are missing. Raw data
/// may be shorter than claimed: the caller decides.
Result<ImageFile> read_image_file(const std::filesystem::path& path);

Result<void> interpret_meta_image(ImageFile& file, std::int64_t data_offset,
                                  std::int64_t file_size);
Result<void> interpret_nrrd(ImageFile& file, std::int64_t data_offset, std::int64_t file_size);

/// Error of malformed content: "<path>: <key>: expected <expected>, found '<found>'".
Error bad_field(const ImageFile& file, std::string_view key, const std::string& expected,
                std::string_view found);

/// The files that "name.raw" or "name%03d.raw min max step" mean, beside the header.
Result<std::vector<DataPart>> detached_parts(const ImageFile& file, std::string_view key,
                                             std::string_view value, std::int64_t skip_bytes);

}  // namespace nav::io::detail
