// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// A separate program, because its `new` counts.
#include <atomic>
#include <cstdlib>
#include <gtest/gtest.h>
#include <new>

#include "io/mcap/mcap_reader.hpp"
#include "tests/io/mcap/mcap_damage.hpp"

namespace {
std::atomic<int> mcap_allocations{0};
std::atomic<std::size_t> largest_allocation{0};
}  // namespace

// Not inlined: the compiler would see malloc() and delete as a mismatch.
__attribute__((noinline)) void* operator new(std::size_t bytes) {
  ++mcap_allocations;
  largest_allocation = std::max<std::size_t>(largest_allocation, bytes);
  void* memory = std::malloc(bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
__attribute__((noinline)) void operator delete(void* memory) noexcept { std::free(memory); }
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace nav::io::mcap {
namespace {

TEST(McapAllocationTest, ARecordedSampleAllocatesNothing) {
  const test::TemporaryFolder folder;
  auto recorder = DeviceRecorder::create(folder / "a.mcap");
  ASSERT_TRUE(test::has_value(recorder));
  test::add_devices(**recorder);
  Sample pose = test::pose_sample(0, 1, 0);
  Sample image = test::image_sample(0, 1, 0, 200, 100);
  const auto run = [&](int from, int to) {
    for (int i = from; i < to; ++i) {
      pose.received = image.received = test::at_ns(std::int64_t{1'000'000} * i);
      ASSERT_TRUE((*recorder)->record(0, pose));
      if (i % 10 != 0) continue;
      ASSERT_TRUE((*recorder)->record(1, image));
    }
  };
  run(0, 5000);
  const int before = mcap_allocations;
  run(5000, 15000);
  // Only the list of the chunks grows, by doubling.
  EXPECT_LE(mcap_allocations - before, 3);
}

/// Lengths and counts that promise more than there is allocate no more than the file has.
TEST(McapAllocationTest, HostileLengthsAllocateNothing) {
  const std::string file = test::small_recording();
  constexpr std::size_t kMost = std::size_t{1} << 20;
  for (const std::uint64_t value : {~std::uint64_t{0}, std::uint64_t{1} << 62,
                                    std::uint64_t{0x7FFFFFFF}, std::uint64_t{1} << 26}) {
    for (const std::size_t width : {4U, 8U}) {
      for (std::size_t at = 0; at + width < file.size(); at += file.size() / 1000) {
        std::string variant = file;
        for (std::size_t i = 0; i < width; ++i) {
          variant[at + i] = static_cast<char>(value >> (8 * i) & 255U);
        }
        largest_allocation = 0;
        const auto input = memory_input("hostile", std::as_bytes(std::span(variant)));
        const auto recording = DeviceRecording::open(input, {true, at % 2 == 0});
        ASSERT_LT(largest_allocation, kMost) << at;
        ASSERT_TRUE(test::has_value(recording));
      }
    }
  }
}

/// A chunk above the limit, in a file that is large enough.
TEST(McapAllocationTest, AChunkAboveTheLimitIsRejectedBeforeItIsRead) {
  constexpr std::uint64_t kBytes = kMaxChunkBytes + 1;
  std::string start(reinterpret_cast<const char*>(kMagic.data()), kMagic.size());
  Buffer head;
  append(head, ChunkHead{0, 0, kBytes, 0, "", kBytes});
  start.append(reinterpret_cast<const char*>(head.data()), head.size());
  largest_allocation = 0;
  auto reader = Reader::open(std::make_shared<test::SparseInput>(start, kBytes, ""));
  ASSERT_TRUE(test::has_value(reader));
  EXPECT_TRUE(reader->next()->is_end());
  EXPECT_EQ(reader->loss().bytes, kBytes + head.size());
  EXPECT_LT(largest_allocation, std::size_t{1} << 20);
}

}  // namespace
}  // namespace nav::io::mcap
