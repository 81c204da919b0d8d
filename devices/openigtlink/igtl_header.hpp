// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "nav/result.hpp"
#include "nav/sample.hpp"

/// Framing of OpenIGTLink messages: header, extended header, content, metadata. Source: the
/// protocol's header versions 1 and 2 (protocol 3 uses header version 2).
namespace nav::devices {

constexpr std::size_t kIgtlHeaderBytes = 58;
constexpr std::size_t kIgtlExtendedHeaderBytes = 12;
constexpr std::size_t kIgtlTypeBytes = 12;
constexpr std::size_t kIgtlDeviceBytes = 20;
constexpr std::uint16_t kIgtlNewestVersion = 3;

/// The 58 bytes before every message.
struct IgtlHeader {
  std::uint16_t version = 1;
  std::array<char, kIgtlTypeBytes> type{};      ///< NULs follow; without any if it is full.
  std::array<char, kIgtlDeviceBytes> device{};  ///< Padded like the type; any bytes.
  std::uint64_t stamp = 0;                      ///< Seconds since 1970 times 2^32; 0: none.
  std::uint64_t body_size = 0;                  ///< Bytes that follow the header.
  std::uint64_t crc = 0;                        ///< CRC-64 of the body.

  /// Views into this header.
  [[nodiscard]] std::string_view type_name() const;
  [[nodiscard]] std::string_view device_name() const;
  /// Stamp in ns since 1970; absent when it is 0.
  [[nodiscard]] std::optional<DeviceTime> device_time() const;
  /// "TRANSFORM ProbeToTracker", escaped, for messages.
  [[nodiscard]] std::string description() const;
};

/// Reads a header; its values are not judged. Precondition: 58 bytes, otherwise a Bug.
IgtlHeader read_igtl_header(std::span<const std::byte, kIgtlHeaderBytes> bytes);
/// Stamp of a device time, at least 0, to the nearest 2^-32 s.
std::uint64_t igtl_stamp(DeviceTime time);

/// One entry of the metadata. The views lie in the buffer of the message.
struct IgtlMetadataEntry {
  std::string_view key;
  std::uint16_t encoding = 3;  ///< IANA character set; 3 is US-ASCII.
  std::string_view value;
};

/// Metadata of a message, checked: every entry lies inside.
class IgtlMetadata {
 public:
  IgtlMetadata() = default;
  [[nodiscard]] std::size_t size() const { return count_; }
  /// Calls \p visit with every entry, in order.
  template <class Visit>
  void for_each(Visit visit) const {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < count_; ++i) visit(entry(i, offset));
  }
  /// Value of the first entry of that key.
  [[nodiscard]] std::optional<std::string_view> find(std::string_view key) const;

 private:
  friend Result<IgtlMetadata> read_igtl_metadata(std::span<const std::byte>,
                                                 std::span<const std::byte>);
  IgtlMetadataEntry entry(std::size_t index, std::size_t& offset) const;
  std::size_t count_ = 0;
  std::span<const std::byte> sizes_;
  std::span<const std::byte> texts_;
};
/// \p header: number and sizes of the entries; \p texts: their keys and values. Rejects sizes that
/// differ from the bytes that are there.
Result<IgtlMetadata> read_igtl_metadata(std::span<const std::byte> header,
                                        std::span<const std::byte> texts);

/// One message whose CRC holds. The views lie in the buffer that it was read from.
struct IgtlMessage {
  IgtlHeader header;
  std::uint32_t message_id = 0;  ///< 0 with header version 1.
  std::span<const std::byte> content;
  IgtlMetadata metadata;
};

/// Sizes of the parts of a body.
struct IgtlParts {
  std::size_t extended_header = 0;
  std::size_t content = 0;
  std::size_t metadata_header = 0;
  std::size_t metadata = 0;
  std::uint32_t message_id = 0;
};
/// Parts of a body of \p body_size bytes that begins with \p start (12 bytes or more of it, unless
/// the version is 1). Rejects parts that do not fit into the body.
Result<IgtlParts> igtl_parts(const IgtlHeader& header, std::span<const std::byte> start);
/// Splits the body of a message. Precondition: the body has the header's size, otherwise a Bug.
Result<IgtlMessage> split_igtl_body(const IgtlHeader& header, std::span<const std::byte> body);

/// Parts of a message around its content.
struct IgtlEnvelope {
  std::uint16_t version = 1;  ///< 1, 2 or 3. Version 1 has neither message id nor metadata.
  std::string_view type{};    ///< At most 12 bytes.
  std::string_view device{};  ///< Bytes after the 20th are cut off.
  std::uint64_t stamp = 0;    ///< Same unit as IgtlHeader::stamp.
  std::uint32_t message_id = 0;
  std::span<const IgtlMetadataEntry> metadata{};
};
/// Appends a whole message. Preconditions: version and type as above, otherwise a Bug.
void append_igtl_message(std::vector<std::byte>& out, const IgtlEnvelope& envelope,
                         std::span<const std::byte> content);

}  // namespace nav::devices
