// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "io/mcap/mcap_bytes.hpp"
#include "io/mcap/mcap_records.hpp"

namespace nav::io::mcap {
namespace {

std::optional<TextMap> take_map(ByteReader& from) {
  ByteReader entries(from.bytes(from.number<std::uint32_t>()));
  TextMap map;
  while (entries.ok() && entries.left() > 0) {
    std::string key(entries.text());
    const std::string_view value = entries.text();
    if (!entries.ok() || !map.emplace(std::move(key), value).second) return std::nullopt;
  }
  return map;
}

template <class Value>
std::optional<std::vector<std::pair<std::uint16_t, Value>>> take_numbers(ByteReader& from) {
  ByteReader entries(from.bytes(from.number<std::uint32_t>()));
  if (entries.left() % (2 + sizeof(Value)) != 0) return std::nullopt;
  std::vector<std::pair<std::uint16_t, Value>> values;
  values.reserve(entries.left() / (2 + sizeof(Value)));
  while (entries.left() > 0) {
    const auto key = entries.number<std::uint16_t>();
    values.emplace_back(key, entries.number<Value>());
  }
  return values;
}

template <class Record>
std::optional<Record> if_done(const ByteReader& from, Record record) {
  if (!from.done()) return std::nullopt;
  return record;
}

}  // namespace

std::optional<Header> parse_header(std::span<const std::byte> content) {
  ByteReader from(content);
  Header record;
  record.profile = from.text();
  record.library = from.text();
  return if_done(from, std::move(record));
}

std::optional<Footer> parse_footer(std::span<const std::byte> content) {
  ByteReader from(content);
  Footer record;
  record.summary_start = from.number<std::uint64_t>();
  record.summary_offset_start = from.number<std::uint64_t>();
  record.summary_crc = from.number<std::uint32_t>();
  return if_done(from, record);
}

std::optional<Schema> parse_schema(std::span<const std::byte> content) {
  ByteReader from(content);
  Schema record;
  record.id = from.number<std::uint16_t>();
  record.name = from.text();
  record.encoding = from.text();
  record.data = from.text();
  if (record.id == 0) return std::nullopt;
  return if_done(from, std::move(record));
}

std::optional<Channel> parse_channel(std::span<const std::byte> content) {
  ByteReader from(content);
  Channel record;
  record.id = from.number<std::uint16_t>();
  record.schema = from.number<std::uint16_t>();
  record.topic = from.text();
  record.message_encoding = from.text();
  auto map = take_map(from);
  if (!map) return std::nullopt;
  record.metadata = *std::move(map);
  return if_done(from, std::move(record));
}

std::optional<MessageHead> parse_message_head(std::span<const std::byte> content) {
  ByteReader from(content);
  MessageHead record;
  record.channel = from.number<std::uint16_t>();
  record.sequence = from.number<std::uint32_t>();
  record.log_time = from.number<std::uint64_t>();
  record.publish_time = from.number<std::uint64_t>();
  if (!from.ok()) return std::nullopt;
  return record;
}

std::optional<ChunkHead> parse_chunk_head(std::span<const std::byte> start,
                                          std::uint64_t content_bytes) {
  ByteReader from(start);
  ChunkHead record;
  record.start_time = from.number<std::uint64_t>();
  record.end_time = from.number<std::uint64_t>();
  record.uncompressed_bytes = from.number<std::uint64_t>();
  record.crc = from.number<std::uint32_t>();
  const auto compression_bytes = from.number<std::uint32_t>();
  record.records_bytes = from.number<std::uint64_t>();
  const bool fits = from.ok() && compression_bytes == 0 && content_bytes >= kChunkHeadBytes &&
                    record.records_bytes == content_bytes - kChunkHeadBytes &&
                    record.uncompressed_bytes == record.records_bytes;
  if (!fits) return std::nullopt;
  return record;
}

std::optional<ChunkIndex> parse_chunk_index(std::span<const std::byte> content) {
  ByteReader from(content);
  ChunkIndex record;
  record.start_time = from.number<std::uint64_t>();
  record.end_time = from.number<std::uint64_t>();
  record.offset = from.number<std::uint64_t>();
  record.length = from.number<std::uint64_t>();
  auto offsets = take_numbers<std::uint64_t>(from);
  if (!offsets) return std::nullopt;
  record.message_indexes = *std::move(offsets);
  record.message_index_bytes = from.number<std::uint64_t>();
  record.compression = from.text();
  record.compressed_bytes = from.number<std::uint64_t>();
  record.uncompressed_bytes = from.number<std::uint64_t>();
  return if_done(from, std::move(record));
}

std::optional<AttachmentHead> parse_attachment_head(std::span<const std::byte> start,
                                                    std::uint64_t content_bytes) {
  ByteReader from(start);
  AttachmentHead record;
  record.log_time = from.number<std::uint64_t>();
  record.create_time = from.number<std::uint64_t>();
  record.name = from.text();
  record.media_type = from.text();
  record.data_bytes = from.number<std::uint64_t>();
  const std::uint64_t around = attachment_head_bytes(record) + 4;
  const bool fits =
      from.ok() && content_bytes >= around && record.data_bytes == content_bytes - around;
  if (!fits) return std::nullopt;
  return record;
}

std::uint64_t attachment_head_bytes(const AttachmentHead& head) {
  return 8 + 8 + 4 + head.name.size() + 4 + head.media_type.size() + 8;
}

std::optional<AttachmentIndex> parse_attachment_index(std::span<const std::byte> content) {
  ByteReader from(content);
  AttachmentIndex record;
  record.offset = from.number<std::uint64_t>();
  record.length = from.number<std::uint64_t>();
  record.head.log_time = from.number<std::uint64_t>();
  record.head.create_time = from.number<std::uint64_t>();
  record.head.data_bytes = from.number<std::uint64_t>();
  record.head.name = from.text();
  record.head.media_type = from.text();
  return if_done(from, std::move(record));
}

std::optional<Statistics> parse_statistics(std::span<const std::byte> content) {
  ByteReader from(content);
  Statistics record;
  record.messages = from.number<std::uint64_t>();
  record.schemas = from.number<std::uint16_t>();
  record.channels = from.number<std::uint32_t>();
  record.attachments = from.number<std::uint32_t>();
  record.metadata = from.number<std::uint32_t>();
  record.chunks = from.number<std::uint32_t>();
  record.start_time = from.number<std::uint64_t>();
  record.end_time = from.number<std::uint64_t>();
  const auto counts = take_numbers<std::uint64_t>(from);
  if (!counts) return std::nullopt;
  record.channel_messages.insert(counts->begin(), counts->end());
  return if_done(from, std::move(record));
}

std::optional<Metadata> parse_metadata(std::span<const std::byte> content) {
  ByteReader from(content);
  Metadata record;
  record.name = from.text();
  auto map = take_map(from);
  if (!map) return std::nullopt;
  record.values = *std::move(map);
  return if_done(from, std::move(record));
}

std::optional<MetadataIndex> parse_metadata_index(std::span<const std::byte> content) {
  ByteReader from(content);
  MetadataIndex record;
  record.offset = from.number<std::uint64_t>();
  record.length = from.number<std::uint64_t>();
  record.name = from.text();
  return if_done(from, std::move(record));
}

std::optional<SummaryOffset> parse_summary_offset(std::span<const std::byte> content) {
  ByteReader from(content);
  SummaryOffset record;
  record.group = static_cast<Opcode>(from.number<std::uint8_t>());
  record.start = from.number<std::uint64_t>();
  record.length = from.number<std::uint64_t>();
  return if_done(from, record);
}

std::optional<std::uint16_t> parse_message_index_head(std::span<const std::byte> start,
                                                      std::uint64_t content_bytes) {
  ByteReader from(start);
  const auto channel = from.number<std::uint16_t>();
  const auto bytes = from.number<std::uint32_t>();
  if (!from.ok() || bytes % 16 != 0 || content_bytes != std::uint64_t{bytes} + 6) {
    return std::nullopt;
  }
  return channel;
}

}  // namespace nav::io::mcap
