// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/mcap/mcap_records.hpp"
#include "nav/result.hpp"
#include "nav/time.hpp"

namespace nav::io::mcap {

/// Largest data of one message, bytes.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{64} << 20;
/// Largest chunk limit that a writer accepts, bytes.
inline constexpr std::size_t kMaxChunkLimit = std::size_t{4} << 20;
/// Largest sum of all schema and channel records, bytes: every chunk repeats them.
inline constexpr std::size_t kMaxPreambleBytes = std::size_t{2} << 20;
/// Largest Metadata record, bytes.
inline constexpr std::size_t kMaxMetadataBytes = std::size_t{1} << 20;
/// Largest chunk that the writer can write and the reader reads, bytes.
inline constexpr std::size_t kMaxChunkBytes = std::size_t{72} << 20;

struct WriterOptions {
  std::size_t chunk_bytes = std::size_t{256} << 10;  ///< A chunk ends when it has so many bytes …
  Duration chunk_time = std::chrono::milliseconds(100);  ///< … or covers so much log time.
  std::string profile = "sonde";
  std::string library = "Sonde";
};

/// Checks the limits: 1 byte to 4 MiB, 1 ns to 1 h.
Result<void> validate(const WriterOptions& options);

/// Writes an MCAP file, uncompressed, chunk by chunk. Every chunk begins with all schemas and
/// channels so far and has a checksum, so that it can be read alone. A chunk reaches the file in
/// one piece when it ends; what a killed process loses is the chunk that was open. After a failed
/// write (disk full, size limit, cable) the file is cut behind its last whole record, and every
/// later call returns the same error. Nothing is allocated for a message once the buffers have
/// grown. Not thread-safe.
class Writer {
 public:
  /// Creates a file. Errors: kIo when it exists (a recording is never overwritten) or cannot be
  /// created; a special file, like a pipe, is written as it is. kUsage: bad options.
  static Result<Writer> create(const std::filesystem::path& path, const WriterOptions& options);
  /// Takes over a descriptor that is open for writing, at its start. \p name: for messages.
  static Result<Writer> adopt(int descriptor, std::string name, const WriterOptions& options);
  Writer(Writer&&) noexcept = default;
  Writer& operator=(Writer&&) noexcept = default;
  /// Closes the file without a summary unless finish() was called. The open chunk is lost.
  ~Writer() = default;

  /// Registers a schema and returns its id. \p record.id is not used.
  Result<std::uint16_t> add_schema(Schema record);
  /// Registers a channel and returns its id. \p record.id is not used.
  Result<std::uint16_t> add_channel(Channel record);
  /// Appends a message; its data are \p data and then \p more. Errors: kUsage for an unknown
  /// channel or too many bytes, which does not stop the writer; kIo as described above.
  Result<void> write(const MessageHead& head, std::span<const std::byte> data,
                     std::span<const std::byte> more = {});
  /// Ends the open chunk if it began \p log_time - chunk_time or earlier. For quiet streams.
  Result<void> advance_to(std::uint64_t log_time);
  /// Ends the open chunk and writes it.
  Result<void> flush();
  /// Writes an attachment. \p head.data_bytes is not used.
  Result<void> attach(AttachmentHead head, std::span<const std::byte> data);
  /// Writes a metadata record, with a checksum. kUsage: larger than kMaxMetadataBytes.
  Result<void> add_metadata(Metadata record);
  /// Ends the file with its summary, syncs and closes it. Later calls: a Bug.
  Result<void> finish();

  /// The reason why nothing more is written; absent while all is well.
  [[nodiscard]] const std::optional<Error>& stopped() const { return stopped_; }
  /// Messages accepted, those in the open chunk included.
  [[nodiscard]] std::uint64_t messages() const { return statistics_.messages; }
  /// Chunks that reached the file.
  [[nodiscard]] std::uint64_t chunks() const { return statistics_.chunks; }
  /// Bytes that reached the file.
  [[nodiscard]] std::uint64_t size() const { return size_; }

 private:
  /// A descriptor that is closed with its owner.
  class Descriptor {
   public:
    Descriptor() = default;
    explicit Descriptor(int value) : value_(value) {}
    Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
      std::swap(value_, other.value_);
      return *this;
    }
    ~Descriptor();
    [[nodiscard]] int get() const { return value_; }
    /// Closes it and returns 0, or the reason why that failed.
    int close();

   private:
    int value_ = -1;
  };

  Writer() = default;
  [[nodiscard]] Result<void> usable() const;
  Result<void> put(std::span<const std::byte> bytes, std::uint64_t record_start);
  Result<void> put_record(const Buffer& record);
  Error stop(int reason, std::uint64_t record_start);
  Result<void> repeat_in_chunks(Buffer& records, std::size_t before);
  Result<void> make_ready(std::uint64_t log_time);
  void note(const MessageHead& head);
  void append_message_indexes(std::size_t records_end);
  void forget_chunk();
  Result<void> put_summary();

  std::string name_;
  WriterOptions options_;
  Descriptor descriptor_;
  std::uint64_t size_ = 0;
  std::uint32_t data_crc_ = 0;  ///< Checksum of the file so far.
  std::optional<Error> stopped_;

  Buffer schemas_, channels_;  ///< All records so far, which every chunk repeats.
  Buffer chunk_;  ///< The open chunk: its head, its records, then its indexes; empty: none.
  std::uint64_t chunk_start_ = 0, chunk_end_ = 0;           ///< Log times of the open chunk.
  std::vector<std::vector<IndexedMessage>> open_messages_;  ///< Those of the open chunk by channel.
  Buffer scratch_;
  ChunkIndex entry_;  ///< Reused.

  Statistics statistics_;
  std::vector<std::uint64_t> counts_;  ///< Messages by channel.
  Buffer chunk_indexes_, attachment_indexes_, metadata_indexes_;
};

}  // namespace nav::io::mcap
