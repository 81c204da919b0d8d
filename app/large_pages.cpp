// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The `new` of the whole program, including its libraries. It puts large blocks into large pages
// when the system has them. Volumes, features and images take megabytes; touching them for the
// first time in pages of 4096 bytes takes longer than reading them (ADR 50). Sanitizers have their
// own `new`.
#include "nav/large_pages.hpp"

#include <cstdlib>
#include <new>

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
namespace {
constexpr std::size_t kLeastBytes =
    2 * nav::kLargePage;  // Contains a whole large page at any address.
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
