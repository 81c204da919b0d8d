// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/polhemus_codec.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <utility>

#include "devices/ndi/ndi_bytes.hpp"

namespace nav::devices {
namespace {

/// More than any answer of the device.
constexpr std::size_t kLargestPolhemusBody = 1024;

struct PolhemusHeader {
  int station = 0;
  char command = '\0';
  std::uint8_t error = 0;
  std::size_t size = 0;
  [[nodiscard]] bool is_record() const {
    const int lower = std::tolower(static_cast<unsigned char>(command));
    return lower == 'c' || lower == 'p';
  }
  [[nodiscard]] bool is_of_station() const {
    return station >= 1 && station <= kMostPolhemusStations;
  }
};

bool has_magic(std::span<const std::byte> bytes) {
  return bytes.size() >= 2 && bytes[0] == std::byte{'L'} && bytes[1] == std::byte{'Y'};
}

/// Precondition: kPolhemusHeaderBytes bytes that begin with the magic.
PolhemusHeader read_header(std::span<const std::byte> bytes) {
  NdiByteReader reader(bytes);
  reader.skip(2);
  PolhemusHeader header;
  header.station = reader.number<std::uint8_t>();
  header.command = static_cast<char>(reader.number<std::uint8_t>());
  header.error = reader.number<std::uint8_t>();
  reader.skip(1);
  header.size = reader.number<std::uint16_t>();
  return header;
}

/// True if a whole header of a record that makes sense begins here.
bool begins_record(std::span<const std::byte> bytes) {
  if (!has_magic(bytes) || bytes.size() < kPolhemusHeaderBytes) return false;
  const PolhemusHeader header = read_header(bytes);
  return header.is_record() && header.is_of_station() && header.size == kPolhemusRecordBytes;
}

PolhemusRecord read_record(const PolhemusHeader& header, std::span<const std::byte> body) {
  NdiByteReader reader(body);
  PolhemusRecord record{.station = header.station, .error = header.error};
  record.time_ms = reader.number<std::uint32_t>();
  record.frame = reader.number<std::uint32_t>();
  record.distortion = static_cast<std::int32_t>(reader.number<std::uint32_t>());
  for (float& one : record.position_cm) one = static_cast<float>(reader.float32());
  for (float& one : record.rotation_wxyz) one = static_cast<float>(reader.float32());
  return record;
}

void append_little(std::vector<std::byte>& out, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
}

}  // namespace

std::vector<std::string> polhemus_setup(const std::array<double, 3>& hemisphere) {
  char text[96];
  std::snprintf(text, sizeof text, "h*,%.4f,%.4f,%.4f\r", hemisphere[0], hemisphere[1],
                hemisphere[2]);
  return {"f1\r", "u1\r", "O*,8,9,11,3,7\r", text};
}

const char* polhemus_trouble(const PolhemusRecord& record) {
  constexpr double kFurthestCm = 1000;
  constexpr double kLengthTolerance = 0.01;
  const auto finite = [](float value) { return std::isfinite(value); };
  if (!std::ranges::all_of(record.position_cm, finite) ||
      !std::ranges::all_of(record.rotation_wxyz, finite)) {
    return "not_finite";
  }
  double squares = 0;
  for (const double q : record.rotation_wxyz) squares += q * q;
  if (std::abs(std::sqrt(squares) - 1) > kLengthTolerance) return "no_rotation";
  const bool near = std::ranges::all_of(
      record.position_cm, [](double value) { return std::abs(value) <= kFurthestCm; });
  return near ? nullptr : "out_of_range";
}

std::optional<std::string> polhemus_error(std::uint8_t error) {
  if (error == 0 || error == ' ') return std::nullopt;
  char text[64];
  if (std::isgraph(error) != 0) {
    std::snprintf(text, sizeof text, "error %u ('%c')", error, error);
  } else {
    std::snprintf(text, sizeof text, "error %u", error);
  }
  return text;
}

void PolhemusParser::restart() {
  bytes_.clear();
  in_step_ = true;
}

void PolhemusParser::take(std::span<const std::byte> transfer, const Take& out) {
  if (!bytes_.empty() && begins_record(transfer)) {
    if (in_step_) out({.cause = "cut"});
    restart();
  }
  bytes_.insert(bytes_.end(), transfer.begin(), transfer.end());
  while (take_message(out)) {
  }
}

/// Leaves bytes out, and counts the first ones of a row only.
void PolhemusParser::reject(const char* cause, std::size_t bytes, const Take& out) {
  if (std::exchange(in_step_, false)) out({.cause = cause});
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(bytes));
}

/// Takes or rejects what comes next; false: it is not there as a whole.
bool PolhemusParser::take_message(const Take& out) {
  constexpr std::size_t kMagicBytes = 2;
  const std::span<const std::byte> all = bytes_;
  if (all.empty() || (all.size() == 1 && all[0] == std::byte{'L'})) return false;
  if (!has_magic(all)) {
    std::size_t skip = 1;
    while (skip < all.size() && all[skip] != std::byte{'L'}) ++skip;
    reject("magic", skip, out);
    return true;
  }
  if (all.size() < kPolhemusHeaderBytes) return false;
  const PolhemusHeader header = read_header(all);
  if (header.is_record() && header.size != kPolhemusRecordBytes && !polhemus_error(header.error)) {
    reject("size", kMagicBytes, out);
    return true;
  }
  if (header.size > kLargestPolhemusBody) {
    reject("size", kMagicBytes, out);
    return true;
  }
  const std::size_t whole = kPolhemusHeaderBytes + header.size;
  // A message that was cut holds the header of the next one.
  for (std::size_t at = kMagicBytes; at < std::min(whole, all.size()); ++at) {
    if (!begins_record(all.subspan(at))) continue;
    reject("cut", at, out);
    return true;
  }
  if (all.size() < whole) return false;
  if (header.is_record() && header.size == kPolhemusRecordBytes) {
    if (!header.is_of_station()) {
      reject("station", whole, out);
      in_step_ = true;
      return true;
    }
    in_step_ = true;
    out({.kind = PolhemusNews::Kind::kRecord,
         .record = read_record(header, all.subspan(kPolhemusHeaderBytes, header.size))});
  } else {
    in_step_ = true;
    out({.kind = PolhemusNews::Kind::kReply, .command = header.command, .error = header.error});
  }
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(whole));
  return true;
}

void append_polhemus_header(std::vector<std::byte>& out, int station, char command,
                            std::uint8_t error, std::size_t size) {
  for (const char letter : {'L', 'Y', static_cast<char>(station), command}) {
    out.push_back(static_cast<std::byte>(letter));
  }
  out.push_back(static_cast<std::byte>(error));
  out.push_back(std::byte{0});
  append_little(out, static_cast<std::uint32_t>(size), 2);
}

void append_polhemus_record(std::vector<std::byte>& out, const PolhemusRecord& record) {
  append_polhemus_header(out, record.station, 'C', record.error, kPolhemusRecordBytes);
  append_little(out, record.time_ms, 4);
  append_little(out, record.frame, 4);
  append_little(out, static_cast<std::uint32_t>(record.distortion), 4);
  for (const float value : record.position_cm) {
    append_little(out, std::bit_cast<std::uint32_t>(value), 4);
  }
  for (const float value : record.rotation_wxyz) {
    append_little(out, std::bit_cast<std::uint32_t>(value), 4);
  }
}

}  // namespace nav::devices
