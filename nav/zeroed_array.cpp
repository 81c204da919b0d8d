// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/zeroed_array.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "nav/large_pages.hpp"

namespace nav {
namespace {

// The address sanitizer does not detect accesses past the end of a mapping.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)

bool is_mapped(std::size_t bytes) { return bytes >= kLargePage; }

void* map(std::size_t bytes) {
  void* at = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return at == MAP_FAILED ? nullptr : at;
}

void unmap(void* mapped, std::size_t bytes) { munmap(mapped, bytes); }

#else

bool is_mapped(std::size_t) { return false; }
void* map(std::size_t) { return nullptr; }
void unmap(void*, std::size_t) {}

#endif

/// First large-page boundary in a mapping.
void* first_large_page(void* mapped) {
  const auto past = reinterpret_cast<std::uintptr_t>(mapped) % kLargePage;
  return static_cast<char*>(mapped) + (past == 0 ? 0 : kLargePage - past);
}

}  // namespace

ZeroedMemory::ZeroedMemory(std::size_t bytes) : bytes_(bytes) {
  if (bytes == 0) return;
  if (bytes > std::numeric_limits<std::size_t>::max() - kLargePage) throw std::bad_alloc();
  if (is_mapped(bytes)) {
    mapped_bytes_ = bytes + kLargePage;
    mapped_ = map(mapped_bytes_);
    if (mapped_ == nullptr) throw std::bad_alloc();
    ask_for_large_pages(mapped_, mapped_bytes_);
    data_ = first_large_page(mapped_);
  } else {
    data_ = std::calloc(bytes, 1);
    if (data_ == nullptr) throw std::bad_alloc();
  }
}

ZeroedMemory::~ZeroedMemory() {
  if (mapped_ != nullptr) {
    unmap(mapped_, mapped_bytes_);
  } else {
    std::free(data_);
  }
}

ZeroedMemory::ZeroedMemory(const ZeroedMemory& other) : ZeroedMemory(other.bytes_) {
  if (bytes_ > 0) std::memcpy(data_, other.data_, bytes_);
}

void ZeroedMemory::swap(ZeroedMemory& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(bytes_, other.bytes_);
  std::swap(mapped_, other.mapped_);
  std::swap(mapped_bytes_, other.mapped_bytes_);
}

}  // namespace nav
