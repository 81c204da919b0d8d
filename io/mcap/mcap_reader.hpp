// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/mcap/mcap_input.hpp"
#include "io/mcap/mcap_records.hpp"
#include "io/mcap/mcap_walk.hpp"
#include "io/mcap/mcap_writer.hpp"
#include "nav/result.hpp"

namespace nav::io::mcap {

struct ReaderOptions {
  std::uint64_t max_chunk_bytes = kMaxChunkBytes;  ///< Larger chunks count as damaged.
  bool use_index = true;                           ///< False: scan even if the index is intact.
  WalkFilter filter{};                             ///< Needs the index; all is read without it.
};

/// A message of an intact chunk. Valid until the next call of the reader.
struct Message {
  MessageHead head;
  const Channel* channel = nullptr;
  const Schema* schema = nullptr;  ///< Null: the channel has none.
  /// Changes when the meaning of any channel number has changed.
  std::uint64_t definitions = 0;
  std::span<const std::byte> data;
};

/// One thing in a file: one of these is not null; at the end all are. Valid until the next call of
/// the reader.
struct Event {
  const Message* message = nullptr;
  const AttachmentIndex* attachment = nullptr;
  const Metadata* metadata = nullptr;
  [[nodiscard]] bool is_end() const { return !message && !attachment && !metadata; }
};

/// Reads an MCAP file of any length in constant memory: by its index if that is intact, otherwise
/// from record to record. Gives exactly the messages of the chunks whose checksum holds, also those
/// behind damage. Messages outside chunks and compressed chunks are not read. Not thread-safe.
class Reader {
 public:
  /// Errors: kIo. A file without anything that can be read is no error here.
  static Result<Reader> open(std::shared_ptr<const Input> input, ReaderOptions options = {});

  /// The next thing in the order of the file; with an index, attachments and metadata come after
  /// all messages. Errors: kIo.
  Result<Event> next();
  /// Returns to the start.
  void rewind();

  /// The summary; absent when the file is read without.
  [[nodiscard]] const std::optional<Summary>& summary() const { return summary_; }
  /// True when the file ends with an intact summary, used or not.
  [[nodiscard]] bool is_finished() const { return has_intact_summary_; }
  [[nodiscard]] const Input& input() const { return *input_; }
  /// The parts that could not be read since the start.
  [[nodiscard]] const Loss& loss() const { return walk_->loss(); }
  /// Messages of intact chunks that could not be read, because a record in their chunk is not as
  /// the format says.
  [[nodiscard]] std::uint64_t malformed_chunks() const { return malformed_chunks_; }
  /// One sentence on what was lost since the start, and whether the file was finished; empty when
  /// it was and nothing is lost.
  [[nodiscard]] std::string damage() const;

 private:
  /// A channel or schema as it was last declared, with its bytes.
  template <class Record>
  struct Declared {
    Buffer bytes;
    Record record;
  };

  Reader() = default;
  bool take_record();
  void take_schema(std::span<const std::byte> content);
  void take_channel(std::span<const std::byte> content);
  bool take_message(std::span<const std::byte> content);

  std::shared_ptr<const Input> input_;
  ReaderOptions options_;
  std::optional<Summary> summary_;
  bool has_intact_summary_ = false;
  std::unique_ptr<Walk> walk_;
  std::span<const std::byte> records_;  ///< Rest of the current chunk.
  bool chunk_is_malformed_ = false;
  Message message_;
  std::vector<std::unique_ptr<Declared<Schema>>> schemas_;    ///< Numbered by id.
  std::vector<std::unique_ptr<Declared<Channel>>> channels_;  ///< Numbered by id.
  std::uint64_t definitions_ = 0;
  std::uint64_t malformed_chunks_ = 0;
};

}  // namespace nav::io::mcap
