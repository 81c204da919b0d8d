// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/mcap_walk.hpp"

#include <algorithm>
#include <utility>

#include "io/mcap/mcap_bytes.hpp"

namespace nav::io::mcap {
namespace {

/// Follows the index records of a summary.
class IndexWalk final : public Walk {
 public:
  IndexWalk(std::shared_ptr<const Input> input, const Summary& summary,
            std::uint64_t max_chunk_bytes, WalkFilter filter)
      : Walk(input, max_chunk_bytes),
        input_(std::move(input)),
        window_(*input_),
        at_(summary.start),
        end_(summary.end),
        filter_(std::move(filter)) {}

  Result<const Found*> next() override {
    while (at_ < end_) {
      const auto target = entry();
      if (!target) return target.error();
      if (target->what == Finding::kBad) continue;
      const auto finding = finder_.at(target->offset);
      if (!finding) return finding.error();
      if (*finding == target->what && finder_.found().length == target->length) {
        return &finder_.found();
      }
      loss_.add(target->offset, target->length);
    }
    return nullptr;
  }

 private:
  struct Target {
    Finding what = Finding::kBad;  ///< kBad: none.
    std::uint64_t offset = 0;
    std::uint64_t length = 0;
  };

  /// Reads the next record of the summary.
  Result<Target> entry() {
    const auto prefix = window_.peek(at_, kPrefixBytes);
    if (!prefix) return prefix.error();
    ByteReader from(*prefix);
    const auto opcode = static_cast<Opcode>(from.number<std::uint8_t>());
    const auto bytes = from.number<std::uint64_t>();
    const std::uint64_t content_at = at_ + kPrefixBytes;
    if (!from.ok() || bytes > end_ - content_at) return changed();
    at_ = content_at + bytes;
    const bool is_index =
        opcode == Opcode::kChunkIndex ||
        (filter_.attachments_and_metadata &&
         (opcode == Opcode::kAttachmentIndex || opcode == Opcode::kMetadataIndex));
    if (!is_index) return Target{};
    content_.resize(static_cast<std::size_t>(bytes));
    const auto got = input_->read_at(content_at, content_);
    if (!got) return got.error();
    return target_of(opcode);
  }

  Result<Target> target_of(Opcode opcode) const {
    if (opcode == Opcode::kChunkIndex) {
      const auto index = parse_chunk_index(content_);
      if (!index) return changed();
      if (!is_wanted(*index)) return Target{};
      return Target{Finding::kChunk, index->offset, index->length};
    }
    if (opcode == Opcode::kAttachmentIndex) {
      const auto index = parse_attachment_index(content_);
      if (!index) return changed();
      return Target{Finding::kAttachment, index->offset, index->length};
    }
    const auto index = parse_metadata_index(content_);
    if (!index) return changed();
    return Target{Finding::kMetadata, index->offset, index->length};
  }

  [[nodiscard]] bool is_wanted(const ChunkIndex& index) const {
    if (filter_.channels.empty() || index.message_indexes.empty()) return true;
    return std::any_of(
        index.message_indexes.begin(), index.message_indexes.end(), [&](const auto& entry) {
          return entry.first < filter_.channels.size() && filter_.channels[entry.first];
        });
  }

  [[nodiscard]] Error changed() const {
    return {ErrorCode::kIo,
            input_->name() + ": expected the index as it was when opened, found another"};
  }

  std::shared_ptr<const Input> input_;
  Window window_;
  std::uint64_t at_, end_;
  WalkFilter filter_;
  Buffer content_;
};

/// Goes from record to record.
class ScanWalk final : public Walk {
 public:
  ScanWalk(std::shared_ptr<const Input> input, std::uint64_t max_chunk_bytes)
      : Walk(std::move(input), max_chunk_bytes), size_(finder_.input().size()) {}

  Result<const Found*> next() override {
    if (at_ == 0) {
      const auto magic = is_magic(0);
      if (!magic) return magic.error();
      if (*magic) at_ = kMagic.size();
    }
    while (at_ < size_) {
      const auto finding = finder_.at(at_);
      if (!finding) return finding.error();
      const Found* found = &finder_.found();
      if (*finding == Finding::kBad) {
        const auto behind = behind_damage();
        if (!behind) return behind.error();
        found = *behind;
        if (!found) return nullptr;
      }
      at_ = found->offset + found->length;
      if (found->has_checksum) proven_end_ = at_;
      in_summary_ = in_summary_ || found->what == Finding::kDataEnd;
      if (found->what != Finding::kOther && found->what != Finding::kDataEnd) return found;
    }
    return nullptr;
  }

 private:
  Result<bool> is_magic(std::uint64_t offset) {
    const auto bytes = finder_.window().peek(offset, kMagic.size());
    if (!bytes) return bytes.error();
    return std::equal(bytes->begin(), bytes->end(), kMagic.begin(), kMagic.end());
  }

  /// The next record behind the damage at at_; null: none.
  Result<const Found*> behind_damage() {
    const auto magic = is_magic(at_);
    if (!magic) return magic.error();
    const bool is_end = *magic && at_ + kMagic.size() == size_;
    const auto finding = is_end ? Result<Finding>(Finding::kBad) : finder_.search(proven_end_);
    if (!finding) return finding.error();
    const Found* found = *finding == Finding::kBad ? nullptr : &finder_.found();
    const std::uint64_t stop = found ? found->offset : size_;
    // A record without a checksum may have claimed bytes of the next one.
    const std::uint64_t start = at_ < stop ? at_ : proven_end_;
    // Behind the end of the data lies only what the scan replaces.
    if (!is_end && !in_summary_) loss_.add(start, stop - start);
    at_ = stop;
    return found;
  }

  std::uint64_t at_ = 0;
  std::uint64_t proven_end_ = 0;  ///< End of the last record whose checksum holds.
  std::uint64_t size_;
  bool in_summary_ = false;
};

}  // namespace

void Loss::add(std::uint64_t offset, std::uint64_t length) {
  if (places++ == 0) first = offset;
  bytes += length;
}

std::unique_ptr<Walk> walk_by_index(std::shared_ptr<const Input> input, const Summary& summary,
                                    std::uint64_t max_chunk_bytes, WalkFilter filter) {
  return std::make_unique<IndexWalk>(std::move(input), summary, max_chunk_bytes, std::move(filter));
}

std::unique_ptr<Walk> walk_by_scan(std::shared_ptr<const Input> input,
                                   std::uint64_t max_chunk_bytes) {
  return std::make_unique<ScanWalk>(std::move(input), max_chunk_bytes);
}

}  // namespace nav::io::mcap
