// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/zeroed_array.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <gtest/gtest.h>
#include <numeric>
#include <utility>

#include "nav/large_pages.hpp"

namespace nav {
namespace {

/// Sizes allocated on the heap, sizes allocated from the system, and sizes around the limit between
/// the two.
constexpr std::size_t kSizes[] = {1,          1000,           kLargePage - 1,
                                  kLargePage, kLargePage + 1, 3 * kLargePage + 12345};

TEST(ZeroedArrayTest, IsZeroAtFirstAndKeepsWrittenValues) {
  for (const std::size_t count : kSizes) {
    ZeroedArray<std::uint8_t> array(count);
    ASSERT_EQ(array.size(), count);
    EXPECT_TRUE(std::all_of(array.begin(), array.end(), [](auto v) { return v == 0; })) << count;
    std::iota(array.begin(), array.end(), std::uint8_t{1});
    EXPECT_EQ(array[0], 1);
    EXPECT_EQ(array[count - 1], static_cast<std::uint8_t>(count));
  }
}

TEST(ZeroedArrayTest, ReusedMemoryIsZeroAgain) {
  for (const std::size_t count : kSizes) {
    for (int i = 0; i < 3; ++i) {
      ZeroedArray<std::uint8_t> array(count);
      EXPECT_EQ(std::count(array.begin(), array.end(), 0), static_cast<std::ptrdiff_t>(count));
      std::fill(array.begin(), array.end(), std::uint8_t{255});
    }
  }
}

TEST(ZeroedArrayTest, ACopyHasItsOwnMemory) {
  for (const std::size_t count : kSizes) {
    ZeroedArray<double> array(count);
    array[count - 1] = 3.5;
    ZeroedArray<double> copy = array;
    ASSERT_EQ(copy.size(), count);
    EXPECT_EQ(copy[count - 1], 3.5);
    copy[count - 1] = 7;
    EXPECT_EQ(array[count - 1], 3.5);
    array = copy;
    EXPECT_EQ(array[count - 1], 7);
    EXPECT_NE(array.data(), copy.data());
  }
}

TEST(ZeroedArrayTest, AMoveTakesTheMemory) {
  ZeroedArray<float> array(kLargePage);
  array[5] = 2;
  const float* at = array.data();
  ZeroedArray<float> taken = std::move(array);
  EXPECT_EQ(taken.data(), at);
  EXPECT_EQ(taken.size(), kLargePage);
  ZeroedArray<float> other(3);
  other.swap(taken);
  EXPECT_EQ(other.data(), at);
  EXPECT_EQ(taken.size(), 3U);
  taken = std::move(other);
  EXPECT_EQ(taken[5], 2);
}

TEST(ZeroedArrayTest, AnEmptyArrayWorks) {
  ZeroedArray<int> none(0);
  const ZeroedArray<int> same = none;
  EXPECT_EQ(none.size(), 0U);
  EXPECT_EQ(same.begin(), same.end());
  none = ZeroedArray<int>();
  EXPECT_EQ(none.begin(), none.end());
}

// Excluded under sanitizers: they stop the program if an allocation is too large, and they keep
// more memory than the program touches.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(ZeroedArrayTest, AnAllocationThatIsTooLargeThrows) {
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  for (const std::size_t count : {kAll, kAll / 2, kAll / 8, kAll / 8 + 1, kAll / 16}) {
    EXPECT_THROW(ZeroedArray<double>{count}, std::bad_alloc) << count;
  }
}

#ifdef __linux__
std::size_t resident_pages() {
  std::size_t all = 0;
  std::size_t resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident;
}

TEST(ZeroedArrayTest, UntouchedPagesUseNoMemory) {
  constexpr std::size_t kPages = 50000;  // Pages of 4096 bytes.
  const std::size_t before = resident_pages();
  ASSERT_GT(before, 0U);
  ZeroedArray<std::uint8_t> array(kPages * 4096);
  array[array.size() / 2] = 1;
  EXPECT_LT(resident_pages(), before + kPages / 10);
}
#endif
#endif

}  // namespace
}  // namespace nav
