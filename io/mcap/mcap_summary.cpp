// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "io/mcap/mcap_bytes.hpp"
#include "io/mcap/mcap_crc.hpp"
#include "io/mcap/mcap_walk.hpp"

namespace nav::io::mcap {
namespace {

/// Largest record of a summary, bytes: a chunk index with every channel.
constexpr std::uint64_t kMaxSummaryRecord = std::uint64_t{1} << 20;
/// Largest sum of the records that are kept, bytes.
constexpr std::uint64_t kMaxKeptBytes = std::uint64_t{64} << 20;
constexpr std::uint64_t kEndBytes = kPrefixBytes + kFooterBytes + kMagic.size();

/// Reads a summary record by record. Each step returns false when the summary cannot be trusted.
class SummaryReader {
 public:
  explicit SummaryReader(const Input& input) : input_(input), window_(input) {}

  Result<std::optional<Summary>> read() {
    for (const auto step :
         {&SummaryReader::footer, &SummaryReader::checksum, &SummaryReader::records}) {
      const auto ok = (this->*step)();
      if (!ok) return ok.error();
      if (!*ok) return std::optional<Summary>();
    }
    return std::optional<Summary>(std::move(summary_));
  }

 private:
  Result<bool> footer() {
    if (input_.size() < kMagic.size() + kEndBytes) return false;
    footer_at_ = input_.size() - kEndBytes;
    const auto end = window_.peek(footer_at_, kEndBytes);
    if (!end) return end.error();
    ByteReader from(*end);
    const bool is_footer = static_cast<Opcode>(from.number<std::uint8_t>()) == Opcode::kFooter &&
                           from.number<std::uint64_t>() == kFooterBytes;
    const auto footer = parse_footer(from.bytes(kFooterBytes));
    const auto magic = from.bytes(kMagic.size());
    if (!is_footer || !footer ||
        !std::equal(magic.begin(), magic.end(), kMagic.begin(), kMagic.end())) {
      return false;
    }
    summary_.start = footer->summary_start;
    summary_.end = footer->summary_offset_start != 0 ? footer->summary_offset_start : footer_at_;
    crc_ = footer->summary_crc;
    return crc_ != 0 && summary_.start >= kMagic.size() && summary_.start <= summary_.end &&
           summary_.end <= footer_at_;
  }

  Result<bool> checksum() {
    // The end of the footer's fields that the checksum covers.
    const std::uint64_t end = footer_at_ + kPrefixBytes + kFooterBytes - 4;
    std::uint32_t crc = 0;
    for (std::uint64_t at = summary_.start; at < end;) {
      const auto part = window_.peek(
          at, static_cast<std::size_t>(std::min<std::uint64_t>(end - at, Window::kBytes)));
      if (!part) return part.error();
      if (part->empty()) return false;
      crc = crc32_of(*part, crc);
      at += part->size();
    }
    return crc == crc_;
  }

  Result<bool> records() {
    for (std::uint64_t at = summary_.start; at < summary_.end;) {
      const auto prefix = window_.peek(at, kPrefixBytes);
      if (!prefix) return prefix.error();
      ByteReader from(*prefix);
      const auto opcode = static_cast<Opcode>(from.number<std::uint8_t>());
      const auto bytes = from.number<std::uint64_t>();
      at += kPrefixBytes;
      if (at > summary_.end || bytes > summary_.end - at || bytes > kMaxSummaryRecord) return false;
      content_.resize(static_cast<std::size_t>(bytes));
      const auto got = input_.read_at(at, content_);
      if (!got) return got.error();
      if (*got != bytes || !take(opcode)) return false;
      at += bytes;
    }
    return has_statistics_;
  }

  bool take(Opcode opcode) {
    switch (opcode) {
      case Opcode::kSchema:
        return keep(parse_schema(content_), summary_.schemas);
      case Opcode::kChannel:
        return keep(parse_channel(content_), summary_.channels);
      case Opcode::kStatistics: {
        auto statistics = parse_statistics(content_);
        has_statistics_ = statistics.has_value();
        if (statistics) summary_.statistics = *std::move(statistics);
        return has_statistics_;
      }
      case Opcode::kChunkIndex: {
        const auto index = parse_chunk_index(content_);
        return index && index->compression.empty() && follows(index->offset, index->length);
      }
      case Opcode::kAttachmentIndex: {
        const auto index = parse_attachment_index(content_);
        return index && is_inside(index->offset, index->length);
      }
      case Opcode::kMetadataIndex: {
        const auto index = parse_metadata_index(content_);
        return index && is_inside(index->offset, index->length);
      }
      default:
        return false;
    }
  }

  template <class Record>
  bool keep(std::optional<Record> record, std::vector<Record>& into) {
    kept_bytes_ += content_.size() + sizeof(Record);
    if (!record || kept_bytes_ > kMaxKeptBytes) return false;
    into.push_back(*std::move(record));
    return true;
  }

  [[nodiscard]] bool is_inside(std::uint64_t offset, std::uint64_t length) const {
    return offset >= kMagic.size() && length >= kPrefixBytes && length <= summary_.start &&
           offset <= summary_.start - length;
  }
  /// True for a chunk inside the data and behind the one before it.
  bool follows(std::uint64_t offset, std::uint64_t length) {
    if (!is_inside(offset, length) || offset < chunks_end_) return false;
    chunks_end_ = offset + length;
    return true;
  }

  const Input& input_;
  Window window_;
  Summary summary_;
  std::uint64_t footer_at_ = 0;
  std::uint32_t crc_ = 0;
  std::uint64_t chunks_end_ = 0;
  std::uint64_t kept_bytes_ = 0;
  bool has_statistics_ = false;
  Buffer content_;
};

}  // namespace

Result<std::optional<Summary>> read_summary(const Input& input) {
  return SummaryReader(input).read();
}

}  // namespace nav::io::mcap
