// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "io/mcap/mcap_check.hpp"
#include "io/mcap/mcap_records.hpp"

namespace nav::io::mcap {

/// The summary at the end of a finished file, whose checksum holds. The chunk indexes stay in the
/// file, so that the memory does not grow with its length.
struct Summary {
  std::uint64_t start = 0;  ///< Offset of its first record.
  std::uint64_t end = 0;    ///< Offset behind its last record.
  Statistics statistics;
  std::vector<Schema> schemas;
  std::vector<Channel> channels;
};

/// Reads the summary; absent when it is missing or damaged, or when its chunks overlap or lie
/// outside the file. Errors: kIo.
Result<std::optional<Summary>> read_summary(const Input& input);

/// The parts of a file that could not be read so far.
struct Loss {
  std::uint64_t bytes = 0;
  std::uint64_t places = 0;  ///< With an index: chunks, attachments and metadata records.
  std::uint64_t first = 0;   ///< Offset of the first of them.
  void add(std::uint64_t offset, std::uint64_t length);
};

/// Finds the intact chunks, attachments and metadata records of a file one by one.
class Walk {
 public:
  virtual ~Walk() = default;
  /// The next record; null at the end. Valid until the next call. Errors: kIo.
  virtual Result<const Found*> next() = 0;
  [[nodiscard]] const Loss& loss() const { return loss_; }
  /// True when the search behind damage was given up, see RecordFinder::search().
  [[nodiscard]] bool gave_up() const { return finder_.gave_up(); }

 protected:
  Walk(std::shared_ptr<const Input> input, std::uint64_t max_chunk_bytes)
      : finder_(std::move(input), max_chunk_bytes) {}
  RecordFinder finder_;
  Loss loss_;
};

/// Chooses what a walk by index visits. Without an index everything is visited.
struct WalkFilter {
  bool attachments_and_metadata = true;
  /// Channels whose chunks are wanted, by id; empty: all.
  std::vector<bool> channels{};
};

/// Follows the index.
std::unique_ptr<Walk> walk_by_index(std::shared_ptr<const Input> input, const Summary& summary,
                                    std::uint64_t max_chunk_bytes, WalkFilter filter);
/// Goes from record to record, and behind damage to the next record whose checksum holds.
std::unique_ptr<Walk> walk_by_scan(std::shared_ptr<const Input> input,
                                   std::uint64_t max_chunk_bytes);

}  // namespace nav::io::mcap
