// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/scan_line_file.hpp"

#include <gtest/gtest.h>

#include "io/ct.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

StoredVolume small_volume() {
  VoxelGrid grid;
  grid.size = {3, 4, 5};
  grid.origin_mm = {1, 2, 3};
  return *StoredVolume::create(grid, std::vector<std::int16_t>(60, 9), "small");
}

TEST(ScanLineFileTest, ReadsWhatItWrote) {
  const test::TemporaryFolder folder;
  std::vector<ScanLineAtVoxel> lines(60);
  for (int n = 1; n < 60; ++n) {
    lines[static_cast<std::size_t>(n)] =
        ScanLineAtVoxel::pack(Eigen::Vector3d(n, 1, -2).normalized(), n);
  }
  const auto path = scan_lines_beside(folder / "us.mha");
  EXPECT_EQ(path.filename(), "us.scan-lines.mha");
  ASSERT_TRUE(test::has_value(write_scan_lines(small_volume(), lines, path)));
  const auto read = read_scan_line_file(path);
  ASSERT_TRUE(test::has_value(read));
  EXPECT_EQ(read->lines, lines);
  EXPECT_EQ(read->volume_digest, digest_of(small_volume()));
}

TEST(ScanLineFileTest, RejectsOtherFiles) {
  const test::TemporaryFolder folder;
  const auto path = folder / "us.mha";
  ASSERT_TRUE(test::has_value(write_ct_mha(small_volume(), path)));
  EXPECT_TRUE(test::rejects(read_scan_line_file(path), ErrorCode::kUnsupportedData,
                            {"us.mha", "scan lines", "another kind"}));
  EXPECT_TRUE(test::rejects(read_scan_line_file(folder / "none.mha"), ErrorCode::kNotFound, {}));
}

}  // namespace
}  // namespace nav::io
