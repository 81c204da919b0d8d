// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_header.hpp"

#include <algorithm>

#include "devices/openigtlink/igtl_bytes.hpp"
#include "devices/openigtlink/igtl_crc.hpp"

namespace nav::devices {
namespace {

constexpr std::size_t kMetadataCountBytes = 2;
constexpr std::size_t kMetadataEntryBytes = 8;
constexpr std::uint64_t kNsPerSecond = 1'000'000'000;

Error misfit(const std::string& what, std::uint64_t expected, std::uint64_t found) {
  return {ErrorCode::kMalformedData, what + ": expected " + std::to_string(expected) +
                                         " bytes, found " + std::to_string(found)};
}

}  // namespace

std::string_view IgtlHeader::type_name() const {
  return igtl_until_nul({type.data(), type.size()});
}

std::string_view IgtlHeader::device_name() const {
  return igtl_until_nul({device.data(), device.size()});
}

std::optional<DeviceTime> IgtlHeader::device_time() const {
  if (stamp == 0) return std::nullopt;
  const std::uint64_t seconds = stamp >> 32;
  const std::uint64_t fraction = ((stamp & 0xFFFFFFFFu) * kNsPerSecond + (1u << 31)) >> 32;
  return DeviceTime(
      DeviceClock::duration(static_cast<DeviceClock::rep>(seconds * kNsPerSecond + fraction)));
}

std::string IgtlHeader::description() const {
  const std::string name = igtl_escaped(device_name());
  return igtl_escaped(type_name()) + (name.empty() ? "" : " ") + name;
}

IgtlHeader read_igtl_header(std::span<const std::byte, kIgtlHeaderBytes> bytes) {
  IgtlReader reader(bytes);
  IgtlHeader header;
  header.version = reader.number<std::uint16_t>();
  std::ranges::copy(reader.characters(kIgtlTypeBytes), header.type.begin());
  std::ranges::copy(reader.characters(kIgtlDeviceBytes), header.device.begin());
  header.stamp = reader.number<std::uint64_t>();
  header.body_size = reader.number<std::uint64_t>();
  header.crc = reader.number<std::uint64_t>();
  return header;
}

std::uint64_t igtl_stamp(DeviceTime time) {
  const auto ns =
      static_cast<std::uint64_t>(std::max<DeviceClock::rep>(time.time_since_epoch().count(), 0));
  const std::uint64_t fraction = ((ns % kNsPerSecond << 32) + kNsPerSecond / 2) / kNsPerSecond;
  return (ns / kNsPerSecond << 32) + fraction;
}

IgtlMetadataEntry IgtlMetadata::entry(std::size_t index, std::size_t& offset) const {
  IgtlReader sizes(sizes_.subspan(index * kMetadataEntryBytes, kMetadataEntryBytes));
  IgtlMetadataEntry found;
  const std::size_t key_size = sizes.number<std::uint16_t>();
  found.encoding = sizes.number<std::uint16_t>();
  const std::size_t value_size = sizes.number<std::uint32_t>();
  IgtlReader texts(texts_.subspan(offset));
  found.key = texts.characters(key_size);
  found.value = texts.characters(value_size);
  offset += key_size + value_size;
  return found;
}

std::optional<std::string_view> IgtlMetadata::find(std::string_view key) const {
  std::size_t offset = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const IgtlMetadataEntry found = entry(i, offset);
    if (found.key == key) return found.value;
  }
  return std::nullopt;
}

Result<IgtlMetadata> read_igtl_metadata(std::span<const std::byte> header,
                                        std::span<const std::byte> texts) {
  IgtlMetadata metadata;
  if (header.empty() && texts.empty()) return metadata;
  if (header.size() < kMetadataCountBytes) {
    return misfit("metadata header", kMetadataCountBytes, header.size());
  }
  IgtlReader reader(header);
  metadata.count_ = reader.number<std::uint16_t>();
  const std::size_t expected = kMetadataCountBytes + metadata.count_ * kMetadataEntryBytes;
  if (header.size() != expected) {
    return misfit("metadata header with " + std::to_string(metadata.count_) + " entries", expected,
                  header.size());
  }
  metadata.sizes_ = header.subspan(kMetadataCountBytes);
  metadata.texts_ = texts;
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < metadata.count_; ++i) {
    total += reader.number<std::uint16_t>();
    reader.number<std::uint16_t>();
    total += reader.number<std::uint32_t>();
  }
  if (total != texts.size()) return misfit("metadata", total, texts.size());
  return metadata;
}

Result<IgtlParts> igtl_parts(const IgtlHeader& header, std::span<const std::byte> start) {
  IgtlParts parts;
  if (header.version == 1) {
    parts.content = static_cast<std::size_t>(header.body_size);
    return parts;
  }
  if (start.size() < kIgtlExtendedHeaderBytes) {
    return misfit(header.description() + ": extended header", kIgtlExtendedHeaderBytes,
                  start.size());
  }
  IgtlReader reader(start);
  parts.extended_header = reader.number<std::uint16_t>();
  parts.metadata_header = reader.number<std::uint16_t>();
  parts.metadata = reader.number<std::uint32_t>();
  parts.message_id = reader.number<std::uint32_t>();
  if (parts.extended_header < kIgtlExtendedHeaderBytes) {
    return misfit(header.description() + ": extended header", kIgtlExtendedHeaderBytes,
                  parts.extended_header);
  }
  const std::uint64_t around = parts.extended_header + parts.metadata_header + parts.metadata;
  if (around > header.body_size) {
    return Error{ErrorCode::kMalformedData,
                 header.description() +
                     ": expected extended header and metadata within the body of " +
                     std::to_string(header.body_size) + " bytes, found " + std::to_string(around) +
                     " bytes"};
  }
  parts.content = static_cast<std::size_t>(header.body_size - around);
  return parts;
}

Result<IgtlMessage> split_igtl_body(const IgtlHeader& header, std::span<const std::byte> body) {
  NAV_CHECK(body.size() == header.body_size, body.size(), header.body_size);
  const auto parts = igtl_parts(header, body);
  if (!parts) return parts.error();
  IgtlReader reader(body);
  reader.bytes(parts->extended_header);
  IgtlMessage message;
  message.header = header;
  message.message_id = parts->message_id;
  message.content = reader.bytes(parts->content);
  const auto metadata_header = reader.bytes(parts->metadata_header);
  const auto metadata = read_igtl_metadata(metadata_header, reader.bytes(parts->metadata));
  if (!metadata) {
    return Error{metadata.error().code, header.description() + ": " + metadata.error().message};
  }
  message.metadata = *metadata;
  return message;
}

void append_igtl_message(std::vector<std::byte>& out, const IgtlEnvelope& envelope,
                         std::span<const std::byte> content) {
  NAV_CHECK(envelope.version >= 1 && envelope.version <= kIgtlNewestVersion, envelope.version);
  NAV_CHECK(envelope.type.size() <= kIgtlTypeBytes, envelope.type);
  NAV_CHECK(envelope.metadata.size() <= 8000, envelope.metadata.size());
  std::uint64_t texts = 0;
  for (const IgtlMetadataEntry& entry : envelope.metadata) {
    NAV_CHECK(entry.key.size() <= UINT16_MAX && entry.value.size() <= UINT32_MAX / 2,
              entry.key.size(), entry.value.size());
    texts += entry.key.size() + entry.value.size();
  }
  NAV_CHECK(texts <= UINT32_MAX, texts);
  const std::size_t metadata_header =
      kMetadataCountBytes + envelope.metadata.size() * kMetadataEntryBytes;
  const bool extended = envelope.version > 1;
  const std::uint64_t body =
      content.size() + (extended ? kIgtlExtendedHeaderBytes + metadata_header + texts : 0);

  IgtlWriter writer(out);
  writer.number(envelope.version);
  writer.text(envelope.type, kIgtlTypeBytes);
  writer.text(envelope.device, kIgtlDeviceBytes);
  writer.number(envelope.stamp);
  writer.number(body);
  writer.number(std::uint64_t{0});
  const std::size_t begin = out.size();
  if (extended) {
    writer.number(static_cast<std::uint16_t>(kIgtlExtendedHeaderBytes));
    writer.number(static_cast<std::uint16_t>(metadata_header));
    writer.number(static_cast<std::uint32_t>(texts));
    writer.number(envelope.message_id);
  }
  writer.bytes(content);
  if (extended) {
    writer.number(static_cast<std::uint16_t>(envelope.metadata.size()));
    for (const IgtlMetadataEntry& entry : envelope.metadata) {
      writer.number(static_cast<std::uint16_t>(entry.key.size()));
      writer.number(entry.encoding);
      writer.number(static_cast<std::uint32_t>(entry.value.size()));
    }
    for (const IgtlMetadataEntry& entry : envelope.metadata) {
      writer.characters(entry.key);
      writer.characters(entry.value);
    }
  }
  const std::uint64_t crc = igtl_crc64(std::span(out).subspan(begin));
  for (std::size_t i = 0; i < sizeof crc; ++i) {
    out[begin - 1 - i] = static_cast<std::byte>(crc >> (8 * i) & 255u);
  }
}

}  // namespace nav::devices
