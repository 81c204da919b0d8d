// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// A separate program, because its `new` counts, and fails beyond a limit.
#include <algorithm>
#include <cstdlib>
#include <gtest/gtest.h>
#include <new>

#include "io/ct.hpp"
#include "io/labels.hpp"
#include "io/sequence.hpp"
#include "io/surface_file.hpp"
#include "tests/io/support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace {
std::size_t read_limit_bytes = ~std::size_t{0};
std::size_t read_largest_bytes = 0;
}  // namespace

// Not inlined: the compiler would see malloc() and delete as a mismatch.
__attribute__((noinline)) void* operator new(std::size_t bytes) {
  read_largest_bytes = std::max(read_largest_bytes, bytes);
  void* memory = bytes <= read_limit_bytes ? std::malloc(bytes) : nullptr;
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
__attribute__((noinline)) void operator delete(void* memory) noexcept { std::free(memory); }
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace nav::io {
namespace {

using test::rejects;
using Code = ErrorCode;

/// Samples of 0, compressed to about a thousandth.
std::string zeros(std::size_t bytes, int window) {
  return test::deflated(std::string(bytes, '\0'), window);
}

constexpr int kZlib = 15;
constexpr int kGzip = 31;
constexpr std::size_t kTrueBytes = 8 << 20;

/// 1 GB by their headers, of which they have 8 MB.
std::vector<std::pair<std::string, std::string>> hostile_files() {
  const std::string size = "16000 16000 2";
  const std::string mha =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nCompressedData = True\n"
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\n"
      "ElementSpacing = 0.01 0.01 1\nDimSize = " +
      size + "\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
  const std::string nrrd =
      "NRRD0004\ntype: int16\ndimension: 3\nspace: LPS\nsizes: " + size +
      "\nspace directions: (0.01,0,0) (0,0.01,0) (0,0,1)\nspace origin: (0,0,0)\n"
      "endian: little\nencoding: gzip\n\n";
  std::string nii(352, '\0');
  const auto put = [&](std::size_t at, auto value) { std::memcpy(&nii[at], &value, sizeof value); };
  put(0, std::int32_t{348});
  const std::int16_t dim[] = {3, 16000, 16000, 2, 1, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i) put(40 + 2 * i, dim[i]);
  put(70, std::int16_t{4});
  for (std::size_t i = 0; i < 8; ++i) put(76 + 4 * i, i == 3 ? 1.0F : 0.01F);
  put(108, 352.0F);
  put(252, std::int16_t{1});
  nii.replace(344, 4, std::string("n+1\0", 4));
  // Noise behind the zeros, so that the length of the file allows what the header claims.
  std::string noise(1 << 20, '\0');
  unsigned state = 7;
  for (char& c : noise) c = static_cast<char>((state = state * 1664525U + 1013904223U) >> 24);
  const std::string samples = std::string(kTrueBytes, '\0') + noise;
  return {{"a.mha", mha + test::deflated(samples, kZlib)},
          {"a.nrrd", nrrd + test::deflated(samples, kGzip)},
          {"a.nii.gz", test::deflated(nii + samples, kGzip)}};
}

TEST(ReadMemoryTest, CompressedFilesThatClaimMuchAreRejectedWithoutRoomForIt) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics unheard;
  for (const auto& [name, bytes] : hostile_files()) {
    const auto file = folder / name;
    test::put(file, bytes);
    read_largest_bytes = 0;
    EXPECT_TRUE(rejects(read_ct(file, unheard), Code::kMalformedData, {name, "cut short"}));
    EXPECT_LE(read_largest_bytes, 6 * kTrueBytes) << name;
    read_largest_bytes = 0;
    EXPECT_FALSE(read_labels(file, unheard).has_value());
    EXPECT_LE(read_largest_bytes, 6 * kTrueBytes) << name;
  }
}

TEST(ReadMemoryTest, AFrameOfACompressedSequenceTakesNoMoreThanItHas) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.igs.mha";
  test::put(file,
            "ObjectType = Image\nNDims = 3\nBinaryData = True\nCompressedData = True\n"
            "UltrasoundImageOrientation = MF\nKinds = domain domain list\n"
            "DimSize = 9000 9000 1\nElementType = MET_UCHAR\n"
            "Seq_Frame0000_Timestamp = 1\nElementDataFile = LOCAL\n" +
                zeros(kTrueBytes, kZlib) + std::string(100000, 'x'));
  auto reader = SequenceReader::open(file);
  ASSERT_TRUE(test::has_value(reader));
  read_largest_bytes = 0;
  EXPECT_FALSE(reader->read(0).has_value());
  EXPECT_LE(read_largest_bytes, 3 * kTrueBytes);
}

TEST(ReadMemoryTest, SurfacesThatClaimMuchAreRejectedWithoutRoomForIt) {
  const test::TemporaryFolder folder;
  const std::string claims = "2000000000";
  const std::pair<std::string, std::string> files[] = {
      {"a.ply", "ply\nformat ascii 1.0\nelement vertex " + claims +
                    "\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
                    "property list uchar int vertex_indices\nend_header\n0 0 0\n"},
      {"b.ply",
       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
       "property float z\nelement face 1\nproperty list uint int vertex_indices\n"
       "end_header\n0 0 0\n" +
           claims + " 0 0 0\n"},
      {"a.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS " + claims +
                    " float\n0 0 0\n"},
      {"b.vtk",
       "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n0 0 0\n"
       "POLYGONS " +
           claims + " " + claims + "\n3 0 0 0\n"}};
  for (const auto& [name, bytes] : files) {
    test::put(folder / name, bytes);
    read_largest_bytes = 0;
    EXPECT_TRUE(rejects(read_surface(folder / name), Code::kMalformedData, {name}));
    EXPECT_LE(read_largest_bytes, std::size_t{1} << 20) << name;
  }
}

TEST(ReadMemoryTest, AHeaderHasALargestLength) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics unheard;
  for (const char* start : {"ObjectType = Image\nComment = ", "NRRD0004\ncontent: "}) {
    test::put(folder / "a.mha", start + std::string(16 << 20, 'x'));
    read_largest_bytes = 0;
    EXPECT_TRUE(rejects(read_ct(folder / "a.mha", unheard), Code::kMalformedData,
                        {"a.mha", "at most 1 MiB"}));
    EXPECT_LE(read_largest_bytes, std::size_t{4} << 20);
  }
}

TEST(ReadMemoryTest, TooLittleMemoryNamesTheFileAndWhatItNeeds) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics unheard;
  VoxelGrid grid;
  grid.size = {256, 256, 100};
  const auto ct = StoredVolume::create(
      grid, std::vector<std::int16_t>(grid.voxel_count(), std::int16_t{-1000}), "ct");
  ASSERT_TRUE(test::has_value(ct));
  for (const bool compressed : {true, false}) {
    const auto file = folder / (compressed ? "packed.mha" : "raw.mha");
    ASSERT_TRUE(test::has_value(write_ct_mha(*ct, file, compressed)));
    read_limit_bytes = 4 << 20;
    const auto read = read_ct(file, unheard);
    read_limit_bytes = ~std::size_t{0};
    EXPECT_TRUE(rejects(read, Code::kUnavailable,
                        {file.filename().string(), "out of memory", "it needs 13 MB"}));
    EXPECT_TRUE(test::has_value(read_ct(file, unheard)));
  }
}

}  // namespace
}  // namespace nav::io
