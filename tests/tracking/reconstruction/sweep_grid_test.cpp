// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/reconstruction/sweep_grid.hpp"

#include <gtest/gtest.h>

#include "nav/scan_line.hpp"
#include "tests/support/matchers.hpp"

namespace nav::tracking {
namespace {

const std::vector<Point<frames::Reference>> kCorners{{{0, 0, 0}},  {{10, 0, 0}}, {{0, 4, 0}},
                                                     {{10, 4, 0}}, {{0, 0, 3}},  {{10, 0, 3}},
                                                     {{0, 4, 3}},  {{10, 4, 3}}};

TEST(SweepGridTest, CoversTheSweepFromItsLowerCorner) {
  const SweepExtent extent = sweep_extent(kCorners);
  EXPECT_DOUBLE_EQ(extent.motion_mm, 3);
  const auto grid = sweep_grid(extent, 0.8, 0);
  ASSERT_TRUE(test::has_value(grid));
  EXPECT_EQ(grid->size, (std::array<int, 3>{14, 6, 5}));
  EXPECT_EQ(grid->origin_mm, Eigen::Vector3d::Zero());
  const auto wider = sweep_grid(extent, 0.8, 2);
  EXPECT_EQ(wider->size, (std::array<int, 3>{18, 10, 9}));
  EXPECT_TRUE(wider->origin_mm.isApprox(Eigen::Vector3d::Constant(-1.6)));
}

TEST(SweepGridTest, RejectsSpacingsAndTooManyVoxels) {
  const SweepExtent extent = sweep_extent(kCorners);
  for (const double spacing : {0.0, -1.0, std::nan(""), 1e300, 1e-5}) {
    EXPECT_TRUE(
        test::rejects(sweep_grid(extent, spacing, 0), ErrorCode::kUsage, {"voxel spacing", "mm"}));
  }
  EXPECT_TRUE(test::rejects(sweep_grid(extent, 5e-4, 0), ErrorCode::kUsage,
                            {"2^31 voxels", "20001 x 8001 x 6001"}));
}

TEST(ScanLineAtVoxelTest, KeepsDirectionAndDepth) {
  EXPECT_FALSE(ScanLineAtVoxel{}.defined());
  for (const Eigen::Vector3d& v :
       {Eigen::Vector3d(1, 2, -3), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(-1, 1e-3, 0)}) {
    const auto line = ScanLineAtVoxel::pack(v.normalized(), 123.456);
    EXPECT_LT((line.away() - v.normalized()).norm(), 3e-5);
    EXPECT_NEAR(line.depth_mm(), 123.456, 0.5 / 64);
  }
  EXPECT_EQ(ScanLineAtVoxel::pack({0, 1, 0}, 1e6).depth_mm(), 511);
}

}  // namespace
}  // namespace nav::tracking
