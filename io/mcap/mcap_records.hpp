// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

// Records of the MCAP container format, without files. Source: the MCAP format specification,
// https://mcap.dev/spec. All numbers are little endian. Times are ns from an origin that the file
// does not know. append() writes a whole record: opcode, length, content. A parser takes the
// content of one record and gives nothing unless its fields fill the content exactly.

namespace nav::io::mcap {

/// Bytes at both ends of a file.
inline constexpr std::array<std::byte, 8> kMagic = {std::byte{0x89}, std::byte{'M'}, std::byte{'C'},
                                                    std::byte{'A'},  std::byte{'P'}, std::byte{'0'},
                                                    std::byte{'\r'}, std::byte{'\n'}};

enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// Opcode and length before every record, bytes.
inline constexpr std::size_t kPrefixBytes = 9;
/// Content of a Footer record, bytes.
inline constexpr std::size_t kFooterBytes = 20;
/// Content of an uncompressed Chunk record before its records, bytes.
inline constexpr std::size_t kChunkHeadBytes = 40;
/// Content of a Message record before its data, bytes.
inline constexpr std::size_t kMessageHeadBytes = 22;

using TextMap = std::map<std::string, std::string>;

struct Header {
  std::string profile;
  std::string library;
};
struct Footer {
  std::uint64_t summary_start = 0;         ///< Offset in the file; 0: no summary.
  std::uint64_t summary_offset_start = 0;  ///< Offset in the file; 0: none.
  std::uint32_t summary_crc = 0;           ///< 0: not computed.
};
struct Schema {
  std::uint16_t id = 0;  ///< Not 0.
  std::string name;
  std::string encoding;
  std::string data;
};
struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema = 0;  ///< 0: none.
  std::string topic;
  std::string message_encoding;
  TextMap metadata;
};
struct MessageHead {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;
  std::uint64_t publish_time = 0;
};
/// The fields before the records of a chunk. Only the records are covered by the checksum.
struct ChunkHead {
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::uint64_t uncompressed_bytes = 0;
  std::uint32_t crc = 0;
  std::string compression;
  std::uint64_t records_bytes = 0;
};
struct IndexedMessage {
  std::uint64_t log_time = 0;
  std::uint64_t offset = 0;  ///< From the start of the chunk's records, bytes.
};
struct ChunkIndex {
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::uint64_t offset = 0;  ///< Offset of the Chunk record in the file.
  std::uint64_t length = 0;  ///< Length of the Chunk record with its prefix, bytes.
  std::vector<std::pair<std::uint16_t, std::uint64_t>> message_indexes;  ///< Channel, offset.
  std::uint64_t message_index_bytes = 0;
  std::string compression;
  std::uint64_t compressed_bytes = 0;
  std::uint64_t uncompressed_bytes = 0;
};
struct AttachmentHead {
  std::uint64_t log_time = 0;
  std::uint64_t create_time = 0;
  std::string name;
  std::string media_type;
  std::uint64_t data_bytes = 0;
};
struct AttachmentIndex {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;  ///< With the prefix, bytes.
  AttachmentHead head;
};
struct Statistics {
  std::uint64_t messages = 0;
  std::uint16_t schemas = 0;
  std::uint32_t channels = 0;
  std::uint32_t attachments = 0;
  std::uint32_t metadata = 0;
  std::uint32_t chunks = 0;
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::map<std::uint16_t, std::uint64_t> channel_messages;
};
struct Metadata {
  std::string name;
  TextMap values;
};
struct MetadataIndex {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;  ///< With the prefix, bytes.
  std::string name;
};
struct SummaryOffset {
  Opcode group = Opcode::kSchema;
  std::uint64_t start = 0;
  std::uint64_t length = 0;
};

using Buffer = std::vector<std::byte>;

void append(Buffer& out, const Header& record);
void append(Buffer& out, const Footer& record);
void append(Buffer& out, const Schema& record);
void append(Buffer& out, const Channel& record);
/// Only the prefix and the head of a message; \p data_bytes follow.
void append(Buffer& out, const MessageHead& record, std::size_t data_bytes);
void append(Buffer& out, const ChunkHead& record);
void append_message_index(Buffer& out, std::uint16_t channel,
                          std::span<const IndexedMessage> messages);
void append(Buffer& out, const ChunkIndex& record);
/// Only the prefix and the fields before the data. \p record.data_bytes follow, and then the
/// checksum of all from the end of the prefix on.
void append(Buffer& out, const AttachmentHead& record);
void append(Buffer& out, const AttachmentIndex& record);
void append(Buffer& out, const Statistics& record);
void append(Buffer& out, const Metadata& record);
void append(Buffer& out, const MetadataIndex& record);
void append(Buffer& out, const SummaryOffset& record);
void append_data_end(Buffer& out, std::uint32_t data_section_crc);

std::optional<Header> parse_header(std::span<const std::byte> content);
std::optional<Footer> parse_footer(std::span<const std::byte> content);
std::optional<Schema> parse_schema(std::span<const std::byte> content);
std::optional<Channel> parse_channel(std::span<const std::byte> content);
/// The head of a message; the rest of the content, after kMessageHeadBytes, is its data.
std::optional<MessageHead> parse_message_head(std::span<const std::byte> content);
/// The head of an uncompressed chunk, from the first kChunkHeadBytes of its content.
/// \p content_bytes: length of the whole content. Nothing unless the lengths agree with each other
/// and the chunk is not compressed.
std::optional<ChunkHead> parse_chunk_head(std::span<const std::byte> start,
                                          std::uint64_t content_bytes);
std::optional<ChunkIndex> parse_chunk_index(std::span<const std::byte> content);
/// The fields before the data of an attachment, from the start of its content. \p content_bytes:
/// length of the whole content. Nothing unless the lengths agree with each other.
std::optional<AttachmentHead> parse_attachment_head(std::span<const std::byte> start,
                                                    std::uint64_t content_bytes);
std::optional<AttachmentIndex> parse_attachment_index(std::span<const std::byte> content);
std::optional<Statistics> parse_statistics(std::span<const std::byte> content);
std::optional<Metadata> parse_metadata(std::span<const std::byte> content);
std::optional<MetadataIndex> parse_metadata_index(std::span<const std::byte> content);
std::optional<SummaryOffset> parse_summary_offset(std::span<const std::byte> content);
/// Channel of a MessageIndex record, from the first 6 bytes of its content; nothing unless the
/// lengths agree.
std::optional<std::uint16_t> parse_message_index_head(std::span<const std::byte> start,
                                                      std::uint64_t content_bytes);

/// Length of the head of an attachment, bytes from the start of its content.
std::uint64_t attachment_head_bytes(const AttachmentHead& head);

// MCAP has no checksum in Metadata records. Sonde's have one in the key "crc32".

/// The record with the key "crc32": the checksum of the name and the other values.
Metadata with_checksum(Metadata record);
/// The record without that key.
Metadata without_checksum(Metadata record);
enum class MetadataCheck { kIntact, kDamaged, kUnchecked };
/// Compares the key "crc32" with the rest of the record; kUnchecked: there is no such key.
MetadataCheck check(const Metadata& record);

}  // namespace nav::io::mcap
