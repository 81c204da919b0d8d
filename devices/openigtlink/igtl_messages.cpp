// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_messages.hpp"

#include <string>

namespace nav::devices {
namespace {

constexpr std::size_t kErrorNameBytes = 20;
constexpr std::size_t kCommandNameBytes = 128;
constexpr std::size_t kPointNameBytes = 64;
constexpr std::size_t kPointGroupBytes = 32;
constexpr std::size_t kPointOwnerBytes = 20;
constexpr std::size_t kStringHeaderBytes = 4;

Error wrong_bytes(const std::string& what, std::uint64_t expected, std::size_t found) {
  return {ErrorCode::kMalformedData, what + ": expected " + std::to_string(expected) +
                                         " bytes, found " + std::to_string(found)};
}

template <class Record>
Result<IgtlRecords<Record>> decode_records(const char* type, std::span<const std::byte> content) {
  if (content.size() % Record::kWidth == 0) return IgtlRecords<Record>(content);
  return Error{ErrorCode::kMalformedData,
               std::string(type) + ": expected " + std::to_string(Record::kWidth) +
                   " bytes for each entry, found " + std::to_string(content.size()) + " bytes"};
}

}  // namespace

Result<IgtlStatus> decode_igtl_status(std::span<const std::byte> content) {
  if (content.size() < IgtlStatus::kLeastBytes) {
    return wrong_bytes("STATUS before its message", IgtlStatus::kLeastBytes, content.size());
  }
  IgtlReader reader(content);
  IgtlStatus status;
  status.code = reader.number<std::uint16_t>();
  status.subcode = static_cast<std::int64_t>(reader.number<std::uint64_t>());
  status.error_name = reader.text(kErrorNameBytes);
  status.message = reader.text(reader.left());
  return status;
}

void append_igtl_status(std::vector<std::byte>& out, const IgtlStatus& status) {
  IgtlWriter writer(out);
  writer.number(status.code);
  writer.number(static_cast<std::uint64_t>(status.subcode));
  writer.text(status.error_name, kErrorNameBytes);
  writer.text(status.message, status.message.size() + 1);
}

Result<IgtlString> decode_igtl_string(std::span<const std::byte> content) {
  if (content.size() < kStringHeaderBytes) {
    return wrong_bytes("STRING before its text", kStringHeaderBytes, content.size());
  }
  IgtlReader reader(content);
  IgtlString string;
  string.encoding = reader.number<std::uint16_t>();
  const std::size_t length = reader.number<std::uint16_t>();
  if (reader.left() != length) return wrong_bytes("STRING: text", length, reader.left());
  string.text = reader.characters(length);
  return string;
}

void append_igtl_string(std::vector<std::byte>& out, const IgtlString& string) {
  NAV_CHECK(string.text.size() <= UINT16_MAX, string.text.size());
  IgtlWriter writer(out);
  writer.number(string.encoding);
  writer.number(static_cast<std::uint16_t>(string.text.size()));
  writer.characters(string.text);
}

Result<IgtlCommand> decode_igtl_command(std::span<const std::byte> content) {
  if (content.size() < IgtlCommand::kHeaderBytes) {
    return wrong_bytes("COMMAND before its text", IgtlCommand::kHeaderBytes, content.size());
  }
  IgtlReader reader(content);
  IgtlCommand command;
  command.id = reader.number<std::uint32_t>();
  command.name = reader.text(kCommandNameBytes);
  command.encoding = reader.number<std::uint16_t>();
  const std::size_t length = reader.number<std::uint32_t>();
  if (reader.left() != length) return wrong_bytes("COMMAND: text", length, reader.left());
  command.text = reader.characters(length);
  return command;
}

void append_igtl_command(std::vector<std::byte>& out, const IgtlCommand& command) {
  NAV_CHECK(command.text.size() <= UINT32_MAX, command.text.size());
  IgtlWriter writer(out);
  writer.number(command.id);
  writer.text(command.name, kCommandNameBytes);
  writer.number(command.encoding);
  writer.number(static_cast<std::uint32_t>(command.text.size()));
  writer.characters(command.text);
}

Result<IgtlRecords<IgtlTypeName>> decode_igtl_capability(std::span<const std::byte> content) {
  return decode_records<IgtlTypeName>("CAPABILITY", content);
}

void append_igtl_capability(std::vector<std::byte>& out, std::span<const std::string_view> types) {
  IgtlWriter writer(out);
  for (const std::string_view type : types) writer.text(type, IgtlTypeName::kWidth);
}

double IgtlSensor::value(std::size_t index) const {
  NAV_CHECK(index < size(), index, size());
  IgtlReader reader(values.subspan(index * sizeof(double)));
  return reader.float64();
}

Result<IgtlSensor> decode_igtl_sensor(std::span<const std::byte> content) {
  if (content.size() < IgtlSensor::kHeaderBytes) {
    return wrong_bytes("SENSOR before its values", IgtlSensor::kHeaderBytes, content.size());
  }
  IgtlReader reader(content);
  IgtlSensor sensor;
  const std::size_t length = reader.number<std::uint8_t>() * sizeof(double);
  sensor.status = reader.number<std::uint8_t>();
  sensor.unit = reader.number<std::uint64_t>();
  if (reader.left() != length) return wrong_bytes("SENSOR: values", length, reader.left());
  sensor.values = reader.bytes(length);
  return sensor;
}

void append_igtl_sensor(std::vector<std::byte>& out, const IgtlSensor& sensor,
                        std::span<const double> values) {
  NAV_CHECK(values.size() <= UINT8_MAX, values.size());
  IgtlWriter writer(out);
  writer.number(static_cast<std::uint8_t>(values.size()));
  writer.number(sensor.status);
  writer.number(sensor.unit);
  for (const double value : values) writer.float64(value);
}

IgtlPoint IgtlPoint::read(IgtlReader& reader) {
  IgtlPoint point;
  point.name = reader.text(kPointNameBytes);
  point.group = reader.text(kPointGroupBytes);
  for (std::uint8_t& channel : point.rgba) channel = reader.number<std::uint8_t>();
  reader.floats(point.position_mm);
  point.diameter_mm = reader.float32();
  point.owner = reader.text(kPointOwnerBytes);
  return point;
}

void IgtlPoint::write(IgtlWriter& writer) const {
  writer.text(name, kPointNameBytes);
  writer.text(group, kPointGroupBytes);
  for (const std::uint8_t channel : rgba) writer.number(channel);
  writer.floats(position_mm);
  writer.float32(diameter_mm);
  writer.text(owner, kPointOwnerBytes);
}

Result<IgtlRecords<IgtlPoint>> decode_igtl_point(std::span<const std::byte> content) {
  return decode_records<IgtlPoint>("POINT", content);
}

std::optional<IgtlQuery> igtl_query(std::string_view type) {
  constexpr std::size_t kPrefixBytes = 4;
  if (type.size() <= kPrefixBytes) return std::nullopt;
  const std::string_view rest = type.substr(kPrefixBytes);
  if (type.starts_with("GET_")) return IgtlQuery{IgtlQueryKind::kGet, rest};
  if (type.starts_with("STT_")) return IgtlQuery{IgtlQueryKind::kStart, rest};
  if (type.starts_with("STP_")) return IgtlQuery{IgtlQueryKind::kStop, rest};
  if (type.starts_with("RTS_")) return IgtlQuery{IgtlQueryKind::kReply, rest};
  return std::nullopt;
}

void append_igtl_start_tracking(std::vector<std::byte>& out, std::uint32_t period_ms,
                                std::string_view frame) {
  constexpr std::size_t kFrameNameBytes = 32;
  IgtlWriter writer(out);
  writer.number(period_ms);
  writer.text(frame, kFrameNameBytes);
}

}  // namespace nav::devices
