// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

namespace nav::devices {

/// Reads little-endian numbers from left to right. After a number that lies beyond the end, good()
/// is false and all numbers are 0.
class NdiByteReader {
 public:
  explicit NdiByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }
  std::span<const std::byte> take(std::size_t size) {
    if (size > rest_.size()) {
      good_ = false;
      rest_ = {};
      return {};
    }
    const auto taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }
  void skip(std::size_t size) { (void)take(size); }
  template <std::unsigned_integral T>
  T number() {
    std::uint32_t value = 0;
    unsigned shift = 0;
    for (const std::byte byte : take(sizeof(T))) {
      value |= std::to_integer<std::uint32_t>(byte) << shift;
      shift += 8;
    }
    return static_cast<T>(value);
  }
  double float32() { return std::bit_cast<float>(number<std::uint32_t>()); }

 private:
  std::span<const std::byte> rest_;
  bool good_ = true;
};

}  // namespace nav::devices
