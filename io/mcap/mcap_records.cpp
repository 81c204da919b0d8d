// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/mcap_records.hpp"

#include <cstdio>
#include <utility>

#include "io/mcap/mcap_bytes.hpp"
#include "io/mcap/mcap_crc.hpp"

namespace nav::io::mcap {
namespace {

constexpr const char* kChecksumKey = "crc32";

/// Appends a record: the opcode, then its length once the content is there.
class RecordScope {
 public:
  RecordScope(Buffer& out, Opcode opcode) : writer_(out) {
    writer_.number(static_cast<std::uint8_t>(opcode));
    writer_.number(std::uint64_t{0});
    start_ = writer_.size();
  }
  RecordScope(const RecordScope&) = delete;
  RecordScope& operator=(const RecordScope&) = delete;
  /// \p more_bytes: length of the content that the caller appends afterwards.
  void end(std::uint64_t more_bytes = 0) {
    writer_.patch(start_ - 8, static_cast<std::uint64_t>(writer_.size() - start_) + more_bytes);
  }
  ByteWriter* operator->() { return &writer_; }
  ByteWriter& operator*() { return writer_; }

 private:
  ByteWriter writer_;
  std::size_t start_ = 0;
};

void put_map(ByteWriter& out, const TextMap& map) {
  const std::size_t at = out.size();
  out.number(std::uint32_t{0});
  for (const auto& [key, value] : map) {
    out.text(key);
    out.text(value);
  }
  out.patch(at, static_cast<std::uint32_t>(out.size() - at - 4));
}

}  // namespace

void append(Buffer& out, const Header& record) {
  RecordScope scope(out, Opcode::kHeader);
  scope->text(record.profile);
  scope->text(record.library);
  scope.end();
}

void append(Buffer& out, const Footer& record) {
  RecordScope scope(out, Opcode::kFooter);
  scope->number(record.summary_start);
  scope->number(record.summary_offset_start);
  scope->number(record.summary_crc);
  scope.end();
}

void append(Buffer& out, const Schema& record) {
  RecordScope scope(out, Opcode::kSchema);
  scope->number(record.id);
  scope->text(record.name);
  scope->text(record.encoding);
  scope->text(record.data);
  scope.end();
}

void append(Buffer& out, const Channel& record) {
  RecordScope scope(out, Opcode::kChannel);
  scope->number(record.id);
  scope->number(record.schema);
  scope->text(record.topic);
  scope->text(record.message_encoding);
  put_map(*scope, record.metadata);
  scope.end();
}

void append(Buffer& out, const MessageHead& record, std::size_t data_bytes) {
  RecordScope scope(out, Opcode::kMessage);
  scope->number(record.channel);
  scope->number(record.sequence);
  scope->number(record.log_time);
  scope->number(record.publish_time);
  scope.end(data_bytes);
}

void append(Buffer& out, const ChunkHead& record) {
  RecordScope scope(out, Opcode::kChunk);
  scope->number(record.start_time);
  scope->number(record.end_time);
  scope->number(record.uncompressed_bytes);
  scope->number(record.crc);
  scope->text(record.compression);
  scope->number(record.records_bytes);
  scope.end(record.records_bytes);
}

void append_message_index(Buffer& out, std::uint16_t channel,
                          std::span<const IndexedMessage> messages) {
  RecordScope scope(out, Opcode::kMessageIndex);
  scope->number(channel);
  scope->number(static_cast<std::uint32_t>(messages.size() * 16));
  for (const IndexedMessage& message : messages) {
    scope->number(message.log_time);
    scope->number(message.offset);
  }
  scope.end();
}

void append(Buffer& out, const ChunkIndex& record) {
  RecordScope scope(out, Opcode::kChunkIndex);
  scope->number(record.start_time);
  scope->number(record.end_time);
  scope->number(record.offset);
  scope->number(record.length);
  scope->number(static_cast<std::uint32_t>(record.message_indexes.size() * 10));
  for (const auto& [channel, offset] : record.message_indexes) {
    scope->number(channel);
    scope->number(offset);
  }
  scope->number(record.message_index_bytes);
  scope->text(record.compression);
  scope->number(record.compressed_bytes);
  scope->number(record.uncompressed_bytes);
  scope.end();
}

void append(Buffer& out, const AttachmentHead& record) {
  RecordScope scope(out, Opcode::kAttachment);
  scope->number(record.log_time);
  scope->number(record.create_time);
  scope->text(record.name);
  scope->text(record.media_type);
  scope->number(record.data_bytes);
  scope.end(record.data_bytes + 4);
}

void append(Buffer& out, const AttachmentIndex& record) {
  RecordScope scope(out, Opcode::kAttachmentIndex);
  scope->number(record.offset);
  scope->number(record.length);
  scope->number(record.head.log_time);
  scope->number(record.head.create_time);
  scope->number(record.head.data_bytes);
  scope->text(record.head.name);
  scope->text(record.head.media_type);
  scope.end();
}

void append(Buffer& out, const Statistics& record) {
  RecordScope scope(out, Opcode::kStatistics);
  scope->number(record.messages);
  scope->number(record.schemas);
  scope->number(record.channels);
  scope->number(record.attachments);
  scope->number(record.metadata);
  scope->number(record.chunks);
  scope->number(record.start_time);
  scope->number(record.end_time);
  scope->number(static_cast<std::uint32_t>(record.channel_messages.size() * 10));
  for (const auto& [channel, count] : record.channel_messages) {
    scope->number(channel);
    scope->number(count);
  }
  scope.end();
}

void append(Buffer& out, const Metadata& record) {
  RecordScope scope(out, Opcode::kMetadata);
  scope->text(record.name);
  put_map(*scope, record.values);
  scope.end();
}

void append(Buffer& out, const MetadataIndex& record) {
  RecordScope scope(out, Opcode::kMetadataIndex);
  scope->number(record.offset);
  scope->number(record.length);
  scope->text(record.name);
  scope.end();
}

void append(Buffer& out, const SummaryOffset& record) {
  RecordScope scope(out, Opcode::kSummaryOffset);
  scope->number(static_cast<std::uint8_t>(record.group));
  scope->number(record.start);
  scope->number(record.length);
  scope.end();
}

void append_data_end(Buffer& out, std::uint32_t data_section_crc) {
  RecordScope scope(out, Opcode::kDataEnd);
  scope->number(data_section_crc);
  scope.end();
}

namespace {

std::string checksum_of(const Metadata& record) {
  Buffer bytes;
  append(bytes, without_checksum(record));
  char text[9];
  std::snprintf(text, sizeof text, "%08x", crc32_of(bytes));
  return text;
}

}  // namespace

Metadata with_checksum(Metadata record) {
  record.values[kChecksumKey] = checksum_of(record);
  return record;
}

Metadata without_checksum(Metadata record) {
  record.values.erase(kChecksumKey);
  return record;
}

MetadataCheck check(const Metadata& record) {
  const auto found = record.values.find(kChecksumKey);
  if (found == record.values.end()) return MetadataCheck::kUnchecked;
  return found->second == checksum_of(record) ? MetadataCheck::kIntact : MetadataCheck::kDamaged;
}

}  // namespace nav::io::mcap
