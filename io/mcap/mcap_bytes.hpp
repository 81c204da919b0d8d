// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace nav::io::mcap {

/// Appends numbers (little endian) and texts to a buffer.
class ByteWriter {
 public:
  explicit ByteWriter(std::vector<std::byte>& out) : out_(out) {}

  template <std::unsigned_integral T>
  void number(T value) {
    std::array<std::byte, sizeof(T)> bytes;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      bytes[i] = static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i) & 255u);
    }
    this->bytes(bytes);
  }
  void signed64(std::int64_t value) { number(static_cast<std::uint64_t>(value)); }
  void float64(double value) { number(std::bit_cast<std::uint64_t>(value)); }
  void bytes(std::span<const std::byte> from) { out_.insert(out_.end(), from.begin(), from.end()); }
  /// Length in 32 bits, then the bytes. Precondition: shorter than 4 GiB.
  void text(std::string_view from) {
    number(static_cast<std::uint32_t>(from.size()));
    bytes(std::as_bytes(std::span(from)));
  }
  [[nodiscard]] std::size_t size() const { return out_.size(); }
  /// Overwrites a number that was appended at \p at.
  template <std::unsigned_integral T>
  void patch(std::size_t at, T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      out_[at + i] = static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i) & 255u);
    }
  }

 private:
  std::vector<std::byte>& out_;
};

/// Reads numbers (little endian) and texts from untrusted bytes. Reading past the end gives 0 or
/// nothing, and makes ok() false from then on. Nothing is allocated.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  [[nodiscard]] bool ok() const { return ok_; }
  /// True when everything was there and nothing is left.
  [[nodiscard]] bool done() const { return ok_ && rest_.empty(); }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }
  std::span<const std::byte> bytes(std::uint64_t count) {
    if (count > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const auto taken = rest_.first(static_cast<std::size_t>(count));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }
  template <std::unsigned_integral T>
  T number() {
    const auto taken = bytes(sizeof(T));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      value |= std::to_integer<std::uint64_t>(taken[i]) << (8 * i);
    }
    return static_cast<T>(value);
  }
  std::int64_t signed64() { return static_cast<std::int64_t>(number<std::uint64_t>()); }
  double float64() { return std::bit_cast<double>(number<std::uint64_t>()); }
  /// Text with its length in 32 bits before it. It lies in the buffer that is read.
  std::string_view text() {
    const auto taken = bytes(number<std::uint32_t>());
    return {reinterpret_cast<const char*>(taken.data()), taken.size()};
  }

 private:
  std::span<const std::byte> rest_;
  bool ok_ = true;
};

}  // namespace nav::io::mcap
