// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/mcap_check.hpp"

#include <algorithm>
#include <utility>

#include "io/mcap/mcap_bytes.hpp"
#include "io/mcap/mcap_crc.hpp"
#include "io/mcap/mcap_writer.hpp"

namespace nav::io::mcap {
namespace {

/// Largest records of the summary that are looked into, bytes.
constexpr std::uint64_t kMaxSmallRecord = std::uint64_t{1} << 20;

bool can_have_checksum(std::byte opcode) {
  const auto code = static_cast<Opcode>(opcode);
  return code == Opcode::kChunk || code == Opcode::kAttachment || code == Opcode::kMetadata;
}

bool is_well_formed(Opcode opcode, std::span<const std::byte> content) {
  switch (opcode) {
    case Opcode::kHeader:
      return parse_header(content).has_value();
    case Opcode::kFooter:
      return parse_footer(content).has_value();
    case Opcode::kSchema:
      return parse_schema(content).has_value();
    case Opcode::kChannel:
      return parse_channel(content).has_value();
    case Opcode::kChunkIndex:
      return parse_chunk_index(content).has_value();
    case Opcode::kAttachmentIndex:
      return parse_attachment_index(content).has_value();
    case Opcode::kStatistics:
      return parse_statistics(content).has_value();
    case Opcode::kMetadataIndex:
      return parse_metadata_index(content).has_value();
    case Opcode::kSummaryOffset:
      return parse_summary_offset(content).has_value();
    default:
      return false;
  }
}

}  // namespace

RecordFinder::RecordFinder(std::shared_ptr<const Input> input, std::uint64_t max_chunk_bytes)
    : input_(std::move(input)),
      max_chunk_bytes_(max_chunk_bytes),
      window_(*input_),
      most_searched_bytes_(4 * std::min(input_->size(), std::uint64_t{1} << 60) +
                           (std::uint64_t{256} << 20)) {}

Result<Finding> RecordFinder::at(std::uint64_t offset) {
  found_.what = Finding::kBad;
  found_.has_checksum = false;
  const auto start = window_.peek(offset, kPrefixBytes + kChunkHeadBytes);
  if (!start) return start.error();
  if (start->size() < kPrefixBytes) return Finding::kBad;
  const auto opcode = static_cast<Opcode>((*start)[0]);
  const auto bytes = ByteReader(start->subspan(1)).number<std::uint64_t>();
  if (bytes > input_->size() - offset - kPrefixBytes) return Finding::kBad;
  found_.offset = offset;
  found_.length = kPrefixBytes + bytes;
  const auto finding = opcode == Opcode::kChunk        ? chunk(start->subspan(kPrefixBytes), bytes)
                       : opcode == Opcode::kAttachment ? attachment(bytes)
                       : opcode == Opcode::kMetadata   ? metadata(bytes)
                                                       : small(opcode, bytes);
  if (finding) found_.what = *finding;
  return finding;
}

/// Reads bytes into the buffer; false: the input has become shorter.
Result<bool> RecordFinder::read(std::uint64_t offset, std::uint64_t count) {
  if (buffer_.size() < count) buffer_.resize(static_cast<std::size_t>(count));
  const auto got =
      input_->read_at(offset, std::span(buffer_).first(static_cast<std::size_t>(count)));
  if (!got) return got.error();
  read_bytes_ += count;
  return *got == count;
}

Result<Finding> RecordFinder::chunk(std::span<const std::byte> start, std::uint64_t content_bytes) {
  const auto head = parse_chunk_head(start, content_bytes);
  if (!head || content_bytes > max_chunk_bytes_) return Finding::kBad;
  const auto whole = read(found_.offset + kPrefixBytes + kChunkHeadBytes, head->records_bytes);
  if (!whole) return whole.error();
  found_.records =
      std::span<const std::byte>(buffer_).first(static_cast<std::size_t>(head->records_bytes));
  if (!*whole || crc32_of(found_.records) != head->crc) return Finding::kBad;
  found_.has_checksum = true;
  return Finding::kChunk;
}

Result<Finding> RecordFinder::attachment(std::uint64_t content_bytes) {
  std::uint64_t at = found_.offset + kPrefixBytes;
  const auto start = window_.peek(
      at, static_cast<std::size_t>(std::min<std::uint64_t>(content_bytes, Window::kBytes)));
  if (!start) return start.error();
  read_bytes_ += start->size();
  auto head = parse_attachment_head(*start, content_bytes);
  if (!head) return Finding::kBad;
  found_.attachment = {found_.offset, found_.length, *std::move(head)};
  const std::uint64_t end = found_.offset + found_.length - 4;
  std::uint32_t crc = 0;
  while (at < end) {
    const auto part = window_.peek(
        at, static_cast<std::size_t>(std::min<std::uint64_t>(end - at, Window::kBytes)));
    if (!part) return part.error();
    if (part->empty()) return Finding::kBad;
    crc = crc32_of(*part, crc);
    at += part->size();
    read_bytes_ += part->size();
  }
  const auto stored = window_.peek(end, 4);
  if (!stored) return stored.error();
  ByteReader last(*stored);
  if (last.number<std::uint32_t>() != crc || !last.done()) return Finding::kBad;
  found_.has_checksum = true;
  return Finding::kAttachment;
}

Result<Finding> RecordFinder::metadata(std::uint64_t content_bytes) {
  if (content_bytes > kMaxMetadataBytes) return Finding::kBad;
  const auto whole = read(found_.offset + kPrefixBytes, content_bytes);
  if (!whole) return whole.error();
  if (!*whole) return Finding::kBad;
  auto record = parse_metadata(
      std::span<const std::byte>(buffer_).first(static_cast<std::size_t>(content_bytes)));
  if (!record) return Finding::kBad;
  const MetadataCheck checked = check(*record);
  if (checked == MetadataCheck::kDamaged) return Finding::kBad;
  found_.metadata = *std::move(record);
  found_.has_checksum = checked == MetadataCheck::kIntact;
  return Finding::kMetadata;
}

Result<Finding> RecordFinder::small(Opcode opcode, std::uint64_t content_bytes) {
  const std::uint64_t at = found_.offset + kPrefixBytes;
  if (opcode == Opcode::kMessageIndex) {
    const auto start = window_.peek(at, 6);
    if (!start) return start.error();
    return parse_message_index_head(*start, content_bytes) ? Finding::kOther : Finding::kBad;
  }
  if (opcode == Opcode::kDataEnd) return content_bytes == 4 ? Finding::kDataEnd : Finding::kBad;
  const bool known = opcode >= Opcode::kHeader && opcode <= Opcode::kSummaryOffset;
  if (!known || content_bytes > kMaxSmallRecord) return Finding::kBad;
  const auto whole = read(at, content_bytes);
  if (!whole) return whole.error();
  const auto content =
      std::span<const std::byte>(buffer_).first(static_cast<std::size_t>(content_bytes));
  return *whole && is_well_formed(opcode, content) ? Finding::kOther : Finding::kBad;
}

Result<Finding> RecordFinder::search(std::uint64_t offset) {
  while (!gave_up_ && offset + kPrefixBytes <= input_->size()) {
    const auto view = window_.peek_some(offset, kPrefixBytes);
    if (!view) return view.error();
    if (view->empty()) break;
    const auto candidate = std::find_if(view->begin(), view->end(), can_have_checksum);
    offset += static_cast<std::uint64_t>(candidate - view->begin());
    if (candidate == view->end()) continue;
    const std::uint64_t before = read_bytes_;
    const auto finding = at(offset);
    if (!finding || found_.has_checksum) return finding;
    searched_bytes_ += read_bytes_ - before;
    gave_up_ = searched_bytes_ > most_searched_bytes_;
    ++offset;
  }
  found_.what = Finding::kBad;
  return Finding::kBad;
}

}  // namespace nav::io::mcap
