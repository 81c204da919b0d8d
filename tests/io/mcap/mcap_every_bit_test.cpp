// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Checks that take too long for every change.
#include <filesystem>
#include <sys/resource.h>

#include "io/mcap/mcap_writer.hpp"
#include "tests/io/mcap/mcap_damage.hpp"

namespace nav::test {
namespace {

TEST(McapEveryBitTest, AFlippedBitLosesOnlyTheChunkThatItHits) {
  DamagedRecording recording(small_recording());
  for (std::size_t byte = 0; byte < recording.file().size(); ++byte) {
    for (int bit = 0; bit < 8; ++bit) {
      ASSERT_EQ(recording.fault_of_bit(byte, bit), "") << "bit " << bit << " of byte " << byte;
    }
  }
}

/// Needs 4.4 GB of disk for some seconds.
TEST(McapEveryBitTest, ReadsAndWritesBeyond4GiB) {
  const TemporaryFolder folder;
  constexpr std::uint64_t kSpace = 10'000'000'000;
  if (std::filesystem::space(folder.path()).available < kSpace) {
    GTEST_SKIP() << "needs 10 GB of free disk for temporary files";
  }
  constexpr int kSide = 8000;
  constexpr std::uint64_t kImages = 69;
  {
    auto recorder = DeviceRecorder::create(folder / "a.mcap");
    ASSERT_TRUE(has_value(recorder));
    add_devices(**recorder);
    const Sample image = image_sample(0, 1, 1'000'000'000, kSide, kSide);
    for (std::uint64_t i = 0; i < kImages; ++i) {
      Sample next = image;
      next.sequence = i;
      ASSERT_TRUE(has_value((*recorder)->record(1, next)));
      ASSERT_TRUE(has_value((*recorder)->record(0, pose_sample(0, i, 1'000'000'000))));
    }
    ASSERT_TRUE(has_value((*recorder)->finish()));
  }
  rusage before{};
  ::getrusage(RUSAGE_SELF, &before);
  ASSERT_GT(std::filesystem::file_size(folder / "a.mcap"), std::uint64_t{1} << 32);
  for (const bool use_index : {true, false}) {
    const auto recording = DeviceRecording::open(folder / "a.mcap", {false, use_index});
    ASSERT_TRUE(has_value(recording));
    EXPECT_EQ(recording->samples(), 2 * kImages);
    EXPECT_EQ(recording->warnings(), std::vector<std::string>());
    auto source = recording->source(0);
    ASSERT_TRUE(has_value(source));
    const auto poses = drained(**source);
    ASSERT_EQ(poses.size(), kImages);
    EXPECT_EQ(bits_of(poses.back()), bits_of(pose_sample(0, kImages - 1, 1'000'000'000)));
  }
  // One chunk of 64 MB and one image, in each reader.
  constexpr long kMostKilobytes = 512L << 10;
  rusage after{};
  ::getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, kMostKilobytes);
}

}  // namespace
}  // namespace nav::test
