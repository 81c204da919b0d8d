// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <climits>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <webp/decode.h>

#include "io/atomic_file.hpp"
#include "io/detail/scratch_file.hpp"
#include "io/digest.hpp"
#include "io/image_output.hpp"
#include "io/sequence_writer.hpp"
#include "tests/io/support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

using test::rejects;
using Code = ErrorCode;

std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(AtomicFileTest, AppearsOnlyWhenCommitted) {
  const test::TemporaryFolder folder;
  test::put(folder / "a", "old");
  {
    auto file = AtomicFile::create(folder / "a");
    ASSERT_TRUE(test::has_value(file));
    ASSERT_TRUE(test::has_value(file->write("half")));
    EXPECT_EQ(test::get(folder / "a"), "old");
  }
  EXPECT_EQ(test::get(folder / "a"), "old");
  EXPECT_EQ(files_in(folder.path()), 1U);
  auto file = AtomicFile::create(folder / "a");
  ASSERT_TRUE(test::has_value(file));
  ASSERT_TRUE(test::has_value(file->write("new ")));
  AtomicFile moved = std::move(*file);
  ASSERT_TRUE(test::has_value(moved.write("text")));
  EXPECT_EQ(moved.size(), 8U);
  ASSERT_TRUE(test::has_value(moved.commit()));
  EXPECT_EQ(test::get(folder / "a"), "new text");
  EXPECT_EQ(files_in(folder.path()), 1U);
}

TEST(AtomicFileTest, NamesTheReasonWhyItCannotWrite) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(rejects(write_file(folder / "no/a.txt", "x"), Code::kIo, {"no/a.txt", "create"}));
  EXPECT_TRUE(rejects(write_file(folder.path(), "x"), Code::kIo, {"found a folder"}));
  EXPECT_TRUE(rejects(write_file("/dev/full", "x"), Code::kIo, {"/dev/full", "No space left"}));
  test::put(folder / "file", "x");
  EXPECT_TRUE(rejects(write_file(folder / "file/a", "x"), Code::kIo, {"file/a"}));
  // Root may write anywhere, so this part tests something only for other users.
  if (::geteuid() != 0) {
    ASSERT_EQ(::chmod(folder.path().c_str(), 0500), 0);
    EXPECT_TRUE(rejects(write_file(folder / "a", "x"), Code::kIo, {"Permission denied"}));
    ASSERT_EQ(::chmod(folder.path().c_str(), 0700), 0);
  }
  EXPECT_TRUE(rejects(write_file("/proc/sonde.txt", "x"), Code::kIo, {"/proc/sonde.txt"}));
}

TEST(AtomicFileTest, WritesThroughSymbolicLinksAndKeepsThem) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder / "real");
  test::put(folder / "real/a", "old");
  std::filesystem::create_symlink("real/a", folder / "near");
  std::filesystem::create_symlink(folder / "near", folder / "far");
  std::filesystem::create_symlink("real/new", folder / "dangling");
  ASSERT_TRUE(test::has_value(write_file(folder / "far", "new")));
  ASSERT_TRUE(test::has_value(write_file(folder / "dangling", "made")));
  for (const char* link : {"near", "far", "dangling"}) {
    EXPECT_TRUE(std::filesystem::is_symlink(folder / link)) << link;
  }
  EXPECT_EQ(test::get(folder / "real/a"), "new");
  EXPECT_EQ(test::get(folder / "real/new"), "made");
  EXPECT_EQ(files_in(folder / "real"), 2U);
  EXPECT_EQ(files_in(folder.path()), 4U);
}

TEST(AtomicFileTest, AcceptsEveryNameLengthThatTheSystemAccepts) {
  const test::TemporaryFolder folder;
  const std::string longest(NAME_MAX, 'x');
  ASSERT_TRUE(test::has_value(write_file(folder / longest, "x")));
  EXPECT_EQ(test::get(folder / longest), "x");
  const std::string too_long = longest + "x";
  EXPECT_TRUE(
      rejects(AtomicFile::create(folder / too_long), Code::kIo, {too_long, "create", "too long"}));
  EXPECT_EQ(files_in(folder.path()), 1U);
}

/// In a container a process may get the number of an earlier process that was killed.
TEST(AtomicFileTest, PartialFilesOfAKilledProcessDoNotStopIt) {
  const test::TemporaryFolder folder;
  constexpr int kMore = 1000;  // More files than this process has written before.
  for (int i = 0; i < kMore; ++i) {
    test::put(folder / detail::partial_name(::getpid(), i), "left");
  }
  ASSERT_TRUE(test::has_value(write_file(folder / "a", "x")));
  EXPECT_EQ(test::get(folder / "a"), "x");
}

TEST(AtomicFileTest, RejectsCyclicSymbolicLinks) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("b", folder / "a");
  std::filesystem::create_symlink("a", folder / "b");
  EXPECT_TRUE(rejects(write_file(folder / "a", "x"), Code::kIo, {"symbolic links"}));
}

TEST(ReadFileTest, ReadsWholeFilesWithinALimit) {
  const test::TemporaryFolder folder;
  test::put(folder / "a", std::string("x\0y", 3));
  EXPECT_EQ(read_file(folder / "a", 3).value(), std::string("x\0y", 3));
  EXPECT_TRUE(rejects(read_file(folder / "a", 2), Code::kMalformedData, {"at most 2", "found 3"}));
  EXPECT_TRUE(rejects(read_file(folder / "b", 2), Code::kNotFound, {"b"}));
}

TEST(DigestTest, MatchesThePublishedVectors) {
  // Examples of FIPS 180-4.
  EXPECT_EQ(sha256_hex(std::string_view()),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex(bytes("abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

Image2d<Rgba8> image(int shift) {
  std::vector<Rgba8> pixels;
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 13; ++x) {
      pixels.push_back({static_cast<std::uint8_t>(20 * x + shift),
                        static_cast<std::uint8_t>(28 * y), static_cast<std::uint8_t>(x * y + shift),
                        static_cast<std::uint8_t>(255 - 3 * x)});
    }
  }
  return {13, 9, std::move(pixels)};
}

TEST(PngTest, RoundTripsExactlyAndRepeatably) {
  const test::TemporaryFolder folder;
  const auto p = image(0);
  ASSERT_TRUE(test::has_value(write_png(p, folder / "a.png")));
  ASSERT_TRUE(test::has_value(write_png(p, folder / "b.png")));
  EXPECT_EQ(test::get(folder / "a.png"), test::get(folder / "b.png"));
  const auto back = read_png(folder / "a.png");
  ASSERT_TRUE(test::has_value(back));
  ASSERT_EQ(back->width(), 13);
  ASSERT_EQ(back->height(), 9);
  EXPECT_TRUE(std::equal(p.pixels().begin(), p.pixels().end(), back->pixels().begin()));
}

TEST(PngTest, RejectsEmptyImagesAndInvalidFiles) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(rejects(write_png({}, folder / "a.png"), Code::kUsage, {"a.png", "pixels"}));
  EXPECT_TRUE(rejects(write_png(image(0), "/dev/full"), Code::kIo, {"No space left"}));
  test::put(folder / "bad.png", "not an image");
  EXPECT_TRUE(rejects(read_png(folder / "bad.png"), Code::kMalformedData, {"bad.png"}));
  ASSERT_TRUE(test::has_value(write_png(image(0), folder / "a.png")));
  const std::string whole = test::get(folder / "a.png");
  test::put(folder / "cut.png", whole.substr(0, whole.size() / 2));
  EXPECT_TRUE(rejects(read_png(folder / "cut.png"), Code::kMalformedData, {"cut.png"}));
}

TEST(AnimationTest, WritesEveryImageWithItsDuration) {
  const test::TemporaryFolder folder;
  AnimationOptions lossless;
  lossless.lossless = true;
  ASSERT_TRUE(test::has_value(
      write_animation({image(0), image(9), image(40)}, 125, folder / "a.webp", lossless)));
  ASSERT_TRUE(test::has_value(
      write_animation({image(0), image(9), image(40)}, 125, folder / "b.webp", lossless)));
  const std::string file = test::get(folder / "a.webp");
  EXPECT_EQ(file, test::get(folder / "b.webp"));
  EXPECT_EQ(file.substr(0, 4), "RIFF");
  EXPECT_EQ(file.substr(8, 4), "WEBP");
  // A chunk ANMF per image. Its duration is a 24-bit number at offset 12 of the content of the
  // chunk.
  std::size_t frames = 0;
  for (std::size_t at = 12; at + 8 <= file.size();) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(file[at + i]); };
    const std::size_t size = byte(4) | byte(5) << 8 | byte(6) << 16;
    if (file.substr(at, 4) == "ANMF") {
      ++frames;
      EXPECT_EQ(byte(8 + 12) | byte(8 + 13) << 8 | byte(8 + 14) << 16, 125);
    }
    at += 8 + size + size % 2;
  }
  EXPECT_EQ(frames, 3U);
  ASSERT_TRUE(test::has_value(write_animation({image(0)}, 40, folder / "one.webp", lossless)));
  // A single image is a still image that the plain decoder can read.
  const std::string one = test::get(folder / "one.webp");
  int width = 0;
  int height = 0;
  ASSERT_EQ(
      WebPGetInfo(reinterpret_cast<const std::uint8_t*>(one.data()), one.size(), &width, &height),
      1);
  EXPECT_EQ(width, 13);
  EXPECT_EQ(height, 9);
}

TEST(AnimationTest, RejectsInvalidImagesAndOptions) {
  const test::TemporaryFolder folder;
  const auto path = folder / "a.webp";
  EXPECT_TRUE(rejects(write_animation({}, 40, path), Code::kUsage, {"a.webp", "at least 1"}));
  EXPECT_TRUE(rejects(write_animation({image(0)}, 0, path), Code::kUsage, {"1 to 60000 ms"}));
  EXPECT_TRUE(rejects(write_animation({image(0), Image2d<Rgba8>(1, 1, {Rgba8{}})}, 40, path),
                      Code::kUsage, {"image 1", "13 x 9", "1 x 1"}));
  AnimationOptions options;
  options.quality = 200;
  EXPECT_TRUE(rejects(write_animation({image(0)}, 40, path, options), Code::kUsage, {"quality"}));
  EXPECT_EQ(files_in(folder.path()), 0U);
}

}  // namespace
}  // namespace nav::io
