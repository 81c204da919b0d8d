// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "io/mcap/mcap_input.hpp"
#include "io/mcap/mcap_records.hpp"
#include "nav/result.hpp"

namespace nav::io::mcap {

/// Judgement of the bytes at one offset of a file.
enum class Finding {
  kBad,         ///< No record that can be trusted.
  kOther,       ///< A record without a checksum, whose lengths agree with each other.
  kDataEnd,     ///< A record like kOther that ends the data.
  kChunk,       ///< A chunk whose checksum holds.
  kAttachment,  ///< An attachment whose checksum holds.
  kMetadata,    ///< A metadata record whose checksum holds, or that has none.
};

/// A record in a file.
struct Found {
  Finding what = Finding::kBad;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;            ///< With the prefix, bytes.
  std::span<const std::byte> records;  ///< kChunk: valid until the next call.
  AttachmentIndex attachment;          ///< kAttachment.
  Metadata metadata;                   ///< kMetadata.
  bool has_checksum = false;           ///< A checksum holds for this record.
};

/// Finds records that can be trusted in a file that may be damaged anywhere. Memory: one chunk of
/// at most the limit. Nothing larger than the file is allocated, whatever its lengths say. Not
/// thread-safe.
class RecordFinder {
 public:
  /// \p max_chunk_bytes: larger chunks are kBad.
  RecordFinder(std::shared_ptr<const Input> input, std::uint64_t max_chunk_bytes);

  /// Judges the bytes at \p offset. Errors: kIo.
  Result<Finding> at(std::uint64_t offset);
  /// Searches from \p offset on for the next record whose checksum holds; kBad: there is none. The
  /// work is limited to some times the length of the file, in sum over all calls; behind the limit
  /// nothing is found.
  Result<Finding> search(std::uint64_t offset);
  /// The record of the last call.
  [[nodiscard]] const Found& found() const { return found_; }
  /// True when the limit of search() was reached.
  [[nodiscard]] bool gave_up() const { return gave_up_; }
  Window& window() { return window_; }
  [[nodiscard]] const Input& input() const { return *input_; }

 private:
  Result<Finding> chunk(std::span<const std::byte> start, std::uint64_t content_bytes);
  Result<Finding> attachment(std::uint64_t content_bytes);
  Result<Finding> metadata(std::uint64_t content_bytes);
  Result<Finding> small(Opcode opcode, std::uint64_t content_bytes);
  Result<bool> read(std::uint64_t offset, std::uint64_t count);

  std::shared_ptr<const Input> input_;
  std::uint64_t max_chunk_bytes_;
  Window window_;
  Buffer buffer_;
  Found found_;
  std::uint64_t read_bytes_ = 0;
  std::uint64_t searched_bytes_ = 0;  ///< Those that search() read in vain.
  std::uint64_t most_searched_bytes_;
  bool gave_up_ = false;
};

}  // namespace nav::io::mcap
