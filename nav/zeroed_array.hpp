// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <new>
#include <type_traits>

namespace nav {

/// Memory whose bytes are 0 until they are written. Blocks of a large page or more are mapped: the
/// system provides each page when a thread first touches it, as a large page if possible. No time
/// is spent on zeros that are overwritten anyway, and large pages reduce the TLB misses of rays and
/// stencils that step from page to page.
class ZeroedMemory {
 public:
  ZeroedMemory() = default;
  /// Throws std::bad_alloc.
  explicit ZeroedMemory(std::size_t bytes);
  ~ZeroedMemory();
  ZeroedMemory(const ZeroedMemory& other);
  ZeroedMemory(ZeroedMemory&& other) noexcept { swap(other); }
  ZeroedMemory& operator=(ZeroedMemory other) noexcept {
    swap(other);
    return *this;
  }
  void swap(ZeroedMemory& other) noexcept;

  [[nodiscard]] void* data() const { return data_; }

 private:
  void* data_ = nullptr;
  std::size_t bytes_ = 0;
  /// Start of the mapping that contains data_; null: data_ is on the heap.
  void* mapped_ = nullptr;
  std::size_t mapped_bytes_ = 0;
};

/// Array of fixed size of plain values, all 0 at first; its memory is a ZeroedMemory.
template <class T>
class ZeroedArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  ZeroedArray() = default;
  /// Throws std::bad_alloc.
  explicit ZeroedArray(std::size_t count) : memory_(bytes_of(count)), size_(count) {}
  ZeroedArray(const ZeroedArray&) = default;
  ZeroedArray(ZeroedArray&& other) noexcept { swap(other); }
  ~ZeroedArray() = default;
  ZeroedArray& operator=(ZeroedArray other) noexcept {
    swap(other);
    return *this;
  }
  void swap(ZeroedArray& other) noexcept {
    memory_.swap(other.memory_);
    const std::size_t size = size_;
    size_ = other.size_;
    other.size_ = size;
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] T* data() { return static_cast<T*>(memory_.data()); }
  [[nodiscard]] const T* data() const { return static_cast<const T*>(memory_.data()); }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  [[nodiscard]] const T* begin() const { return data(); }
  [[nodiscard]] const T* end() const { return data() + size_; }

 private:
  static std::size_t bytes_of(std::size_t count) {
    if (count > std::numeric_limits<std::size_t>::max() / sizeof(T)) throw std::bad_alloc();
    return count * sizeof(T);
  }
  ZeroedMemory memory_;
  std::size_t size_ = 0;
};

}  // namespace nav
