// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "devices/openigtlink/igtl_text.hpp"
#include "nav/check.hpp"

namespace nav::devices {

/// Reads numbers (big endian) and fields of fixed width one after the other. Reading past the end
/// is a Bug: callers compare sizes first.
class IgtlReader {
 public:
  explicit IgtlReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  [[nodiscard]] std::size_t left() const { return rest_.size(); }
  std::span<const std::byte> bytes(std::size_t count) {
    NAV_CHECK(count <= rest_.size(), count, rest_.size());
    const auto taken = rest_.first(count);
    rest_ = rest_.subspan(count);
    return taken;
  }
  template <std::unsigned_integral T>
  T number() {
    std::uint64_t value = 0;
    for (const std::byte b : bytes(sizeof(T))) {
      value = value << 8 | std::to_integer<std::uint64_t>(b);
    }
    return static_cast<T>(value);
  }
  float float32() { return std::bit_cast<float>(number<std::uint32_t>()); }
  double float64() { return std::bit_cast<double>(number<std::uint64_t>()); }
  template <std::size_t N>
  void floats(std::array<float, N>& into) {
    for (float& value : into) value = float32();
  }
  /// Bytes as characters; they lie in the buffer that is read.
  std::string_view characters(std::size_t count) {
    const auto taken = bytes(count);
    return {reinterpret_cast<const char*>(taken.data()), taken.size()};
  }
  /// Text of a field of fixed width.
  std::string_view text(std::size_t width) { return igtl_until_nul(characters(width)); }

 private:
  std::span<const std::byte> rest_;
};

/// Appends numbers (big endian) and fields of fixed width to a buffer.
class IgtlWriter {
 public:
  explicit IgtlWriter(std::vector<std::byte>& out) : out_(out) {}

  template <std::unsigned_integral T>
  void number(T value) {
    for (std::size_t i = sizeof(T); i-- > 0;) {
      out_.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i) & 255u));
    }
  }
  void float32(float value) { number(std::bit_cast<std::uint32_t>(value)); }
  void float64(double value) { number(std::bit_cast<std::uint64_t>(value)); }
  template <std::size_t N>
  void floats(const std::array<float, N>& values) {
    for (const float value : values) float32(value);
  }
  void bytes(std::span<const std::byte> from) { out_.insert(out_.end(), from.begin(), from.end()); }
  void characters(std::string_view from) { bytes(std::as_bytes(std::span(from))); }
  /// Field of fixed width: the text, cut at the width, then NULs.
  void text(std::string_view from, std::size_t width) {
    const std::size_t length = std::min(from.size(), width);
    characters(from.substr(0, length));
    out_.insert(out_.end(), width - length, std::byte{0});
  }

 private:
  std::vector<std::byte>& out_;
};

/// Records of fixed width that follow each other in a message. They are read when asked for, and
/// lie in the message's buffer.
template <class Record>
class IgtlRecords {
 public:
  IgtlRecords() = default;
  /// Precondition: a multiple of the width of a record, otherwise a Bug.
  explicit IgtlRecords(std::span<const std::byte> bytes) : bytes_(bytes) {
    NAV_CHECK(bytes.size() % Record::kWidth == 0, bytes.size(), Record::kWidth);
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size() / Record::kWidth; }
  /// Precondition: index < size(), otherwise a Bug.
  [[nodiscard]] Record operator[](std::size_t index) const {
    NAV_CHECK(index < size(), index, size());
    IgtlReader reader(bytes_.subspan(index * Record::kWidth, Record::kWidth));
    return Record::read(reader);
  }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace nav::devices
