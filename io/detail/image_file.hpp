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

#include "io/detail/input_file.hpp"
#include "io/pixel_type.hpp"
#include "nav/diagnostics.hpp"
#include "nav/result.hpp"

namespace nav::io::detail {

enum class Encoding { kRaw, kDeflate };  ///< kDeflate: one zlib or gzip stream over everything.

/// Deflate expands data by at most 1032 : 1.
constexpr std::int64_t kMostExpansion = 1100;

/// Location of a part of the samples.
struct DataPart {
  std::filesystem::path path;
  std::int64_t offset = 0;
  std::int64_t size = 0;  ///< Available (encoded) bytes.
};

using Field = std::pair<std::string_view, std::string_view>;

/// Content of a MetaImage or NRRD header: everything that is needed to find the samples.
struct ImageFile {
  std::filesystem::path path;
  std::string format;                 ///< "MetaImage" or "NRRD".
  std::unique_ptr<std::string> text;  ///< Text of the header; keys and values point into it.
  std::vector<Field> fields;          ///< Every key and value, trimmed, in order.
  std::map<std::string_view, std::string_view> keys;  ///< Fields outside frames.
  std::vector<std::int64_t> sizes;  ///< Samples along each axis, fastest first, without components.
  std::vector<std::string_view> kinds;  ///< Kind of each axis of sizes, or empty.
  int components = 1;
  std::size_t component_axes = 0;  ///< Axes of the file before those of sizes: 0, or 1 of an NRRD.
  PixelType type = PixelType::kUint8;
  bool big_endian = false;
  Encoding encoding = Encoding::kRaw;
  std::vector<DataPart> data;
  std::shared_ptr<const InputFile> pipe;  ///< Null unless the file is a pipe.
  std::int64_t sample_bytes = 0;          ///< Size of all samples, decoded.
  std::int64_t available_bytes = 0;       ///< Size of data, encoded.
  std::vector<Finding> findings;          ///< Fields that contradict each other or the data.

  /// Value of a key outside frames, or empty.
  [[nodiscard]] std::string_view value(std::string_view key) const;
  [[nodiscard]] bool has(std::string_view key) const { return keys.count(key) != 0; }
};

/// True for "Seq_Frame…" keys, which belong to one frame of a sequence.
bool is_frame_key(std::string_view key);

/// Reads a MetaImage or NRRD header, recognised by the first bytes of the file, and checks it:
/// sizes that overflow, compressed data that cannot expand to these sizes, and missing data files.
/// Raw data may be shorter than declared: the caller decides.
/// A pipe is accepted only with \p pipes.
Result<ImageFile> read_image_file(const std::filesystem::path& path, bool pipes = false);

Result<void> interpret_meta_image(ImageFile& file, std::int64_t data_offset,
                                  std::int64_t file_size);
Result<void> interpret_nrrd(ImageFile& file, std::int64_t data_offset, std::int64_t file_size);

/// Notes spellings of one field that are both in a header and differ; the first one counts.
void compare_spellings(ImageFile& file, std::initializer_list<std::string_view> keys);

/// The key of a header that is \p key in another case; empty if there is none, or if the header has
/// the key itself.
std::string_view other_case(const ImageFile& file, std::string_view key);

/// Notes a key of a header that differs from \p key, which the header lacks, by one letter: it is
/// damaged or mistyped, and what it says is not used. Keys of fewer than six letters are too alike.
/// \p known: all keys of the format, which may be alike.
void note_near_key(ImageFile& file, std::string_view key, std::span<const char* const> known);

/// Error for malformed content: "<path>: <key>: expected <expected>, found '<found>'".
Error bad_field(const ImageFile& file, std::string_view key, const std::string& expected,
                std::string_view found);

/// Data files beside the header, given as "name.raw" or "name%03d.raw min max step".
Result<std::vector<DataPart>> detached_parts(const ImageFile& file, std::string_view key,
                                             std::string_view value, std::int64_t skip_bytes);

}  // namespace nav::io::detail
