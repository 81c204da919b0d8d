// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "devices/openigtlink/igtl_bytes.hpp"
#include "nav/result.hpp"

/// Contents of STATUS, STRING, COMMAND, CAPABILITY, SENSOR and POINT, and the names of queries.
/// Views lie in the buffer that was decoded. Each decoder rejects a content of another size than
/// the format has.
namespace nav::devices {

struct IgtlStatus {
  static constexpr std::size_t kLeastBytes = 30;
  std::uint16_t code = 1;         ///< 1: OK; 2 to 20: kinds of errors.
  std::int64_t subcode = 0;       ///< Device's own.
  std::string_view error_name{};  ///< At most 20 bytes.
  std::string_view message{};
};
Result<IgtlStatus> decode_igtl_status(std::span<const std::byte> content);
void append_igtl_status(std::vector<std::byte>& out, const IgtlStatus& status);

struct IgtlString {
  std::uint16_t encoding = 3;  ///< IANA character set; 3 is US-ASCII.
  std::string_view text;       ///< At most 65535 bytes.
};
Result<IgtlString> decode_igtl_string(std::span<const std::byte> content);
void append_igtl_string(std::vector<std::byte>& out, const IgtlString& string);

struct IgtlCommand {
  static constexpr std::size_t kHeaderBytes = 138;
  std::uint32_t id = 0;
  std::string_view name;  ///< At most 128 bytes.
  std::uint16_t encoding = 3;
  std::string_view text;
};
Result<IgtlCommand> decode_igtl_command(std::span<const std::byte> content);
void append_igtl_command(std::vector<std::byte>& out, const IgtlCommand& command);

/// One message type that a peer knows, of CAPABILITY.
struct IgtlTypeName {
  static constexpr std::size_t kWidth = 12;
  std::string_view name;
  static IgtlTypeName read(IgtlReader& reader) { return {reader.text(kWidth)}; }
};
Result<IgtlRecords<IgtlTypeName>> decode_igtl_capability(std::span<const std::byte> content);
void append_igtl_capability(std::vector<std::byte>& out, std::span<const std::string_view> types);

/// Content of SENSOR: at most 255 values.
struct IgtlSensor {
  static constexpr std::size_t kHeaderBytes = 10;
  std::uint8_t status = 0;  ///< Reserved.
  std::uint64_t unit = 0;   ///< Code of the physical unit.
  std::span<const std::byte> values;

  [[nodiscard]] std::size_t size() const { return values.size() / sizeof(double); }
  /// Precondition: index < size(), otherwise a Bug.
  [[nodiscard]] double value(std::size_t index) const;
};
Result<IgtlSensor> decode_igtl_sensor(std::span<const std::byte> content);
void append_igtl_sensor(std::vector<std::byte>& out, const IgtlSensor& sensor,
                        std::span<const double> values);

struct IgtlPoint {
  static constexpr std::size_t kWidth = 136;
  std::string_view name;   ///< At most 64 bytes.
  std::string_view group;  ///< At most 32 bytes.
  std::array<std::uint8_t, 4> rgba{};
  std::array<float, 3> position_mm{};
  float diameter_mm = 0;
  std::string_view owner;  ///< Name of the image that it belongs to, at most 20 bytes.

  static IgtlPoint read(IgtlReader& reader);
  void write(IgtlWriter& writer) const;
};
Result<IgtlRecords<IgtlPoint>> decode_igtl_point(std::span<const std::byte> content);

enum class IgtlQueryKind { kGet, kStart, kStop, kReply };
/// A type name that asks for data, or answers such a question: GET_IMAGE, STT_TDATA, STP_TDATA,
/// RTS_TDATA.
struct IgtlQuery {
  IgtlQueryKind kind;
  std::string_view of;  ///< The rest of the name; cut to fit into 12 bytes by its sender.
};
/// Absent for other type names.
std::optional<IgtlQuery> igtl_query(std::string_view type);
/// Appends the content of STT_TDATA: the wished period, and the name of the coordinate frame, at
/// most 32 bytes.
void append_igtl_start_tracking(std::vector<std::byte>& out, std::uint32_t period_ms,
                                std::string_view frame = "");

}  // namespace nav::devices
