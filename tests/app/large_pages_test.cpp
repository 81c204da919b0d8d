// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// A separate program, because its `new` is the one of app/large_pages.cpp.
#include <cstddef>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace {

/// Number of bytes of this process that lie in large pages.
std::size_t in_large_pages() {
  std::ifstream file("/proc/self/smaps_rollup");
  std::string word;
  std::size_t kilobytes = 0;
  while (file >> word) {
    if (word == "AnonHugePages:") file >> kilobytes;
  }
  return kilobytes * 1024;
}

bool system_has_large_pages() {
  std::ifstream file("/sys/kernel/mm/transparent_hugepage/enabled");
  std::string modes;
  std::getline(file, modes);
  return modes.find("[never]") == std::string::npos && !modes.empty();
}

TEST(LargePagesTest, LargeVectorsLieInLargePages) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers have a `new` of their own";
#endif
  if (!system_has_large_pages()) GTEST_SKIP() << "transparent_hugepage is off on this system";
  constexpr std::size_t kBytes = std::size_t{64} << 20;
  const std::size_t before = in_large_pages();
  const std::vector<char> block(kBytes, 'x');
  EXPECT_GE(in_large_pages(), before + kBytes / 2);
  EXPECT_EQ(block.back(), 'x');
}

TEST(LargePagesTest, BlocksOfAllSizesDoNotOverlap) {
  std::vector<std::unique_ptr<char[]>> blocks;
  const std::size_t sizes[] = {
      0, 1, 4095, 1 << 20, 1 << 21, (1 << 22) - 1, 1 << 22, (1 << 22) + 1, 12345678};
  for (const std::size_t size : sizes) {
    blocks.push_back(std::make_unique<char[]>(size));
    for (std::size_t i = 0; i < size; i += 4096) ASSERT_EQ(blocks.back()[i], 0);
    if (size > 0) blocks.back()[size - 1] = static_cast<char>(blocks.size());
  }
  for (std::size_t i = 1; i < blocks.size(); ++i) {
    EXPECT_EQ(blocks[i][sizes[i] - 1], static_cast<char>(i + 1));
    EXPECT_NE(blocks[i], blocks[0]);
  }
}

int asked_for_room = 0;

TEST(LargePagesTest, ThrowsBadAllocWhenMemoryIsExhausted) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers have a `new` of their own";
#endif
  volatile std::size_t too_much = std::numeric_limits<std::ptrdiff_t>::max() - 4096;
  EXPECT_THROW(::operator delete(::operator new(too_much)), std::bad_alloc);
  // `new` calls the handler until the handler removes itself.
  std::set_new_handler([] {
    if (++asked_for_room == 3) std::set_new_handler(nullptr);
  });
  EXPECT_THROW(::operator delete(::operator new(too_much)), std::bad_alloc);
  EXPECT_EQ(asked_for_room, 3);
}

}  // namespace
