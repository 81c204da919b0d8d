// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// What `new` gives to the whole program, its libraries included: large blocks lie in large pages
// where the system has them. Volumes, features and pictures are of megabytes, and to touch them for
// the first time in pages of 4096 bytes takes longer than to read them (ADR 50). Sanitizers have
// their own `new`.
#include "nav/large_pages.hpp"

#include <cstdlib>
#include <new>

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
namespace {
constexpr std::size_t kLeastBytes = 2 * nav::kLargePage;  // Holds a large page wherever it lies.
}  // namespace

// Not inlined: the compiler would see malloc() and delete as a mismatch.
__attribute__((noinline)) void* operator new(std::size_t bytes) {
  void* block = nullptr;
  while ((block = std::malloc(bytes > 0 ? bytes : 1)) == nullptr) {
    const std::new_handler make_room = std::get_new_handler();
    if (make_room == nullptr) throw std::bad_alloc();
    make_room();
  }
  if (bytes >= kLeastBytes) nav::ask_for_large_pages(block, bytes);
  return block;
}
__attribute__((noinline)) void operator delete(void* block) noexcept { std::free(block); }
__attribute__((noinline)) void operator delete(void* block, std::size_t) noexcept {
  std::free(block);
}
#endif
