// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/critical_structures.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vector>

namespace nav::session {
namespace {

using ::testing::HasSubstr;

constexpr int kVoxels = 40;

/// 40 mm cube of 1 mm voxels at the origin, with one voxel of 500 HU.
Volume cube_with_voxel(int i, int j, int k) {
  std::vector<std::int16_t> hu(kVoxels * kVoxels * kVoxels, 0);
  hu[static_cast<std::size_t>(i + kVoxels * (j + kVoxels * k))] = 500;
  VoxelGrid grid;
  grid.size = {kVoxels, kVoxels, kVoxels};
  grid.spacing_mm = Eigen::Vector3d::Ones();
  grid.directions = Eigen::Matrix3d::Identity();
  grid.origin_mm = Eigen::Vector3d::Zero();
  return *Volume::create(grid, std::move(hu), "cube");
}

NeedlePlan path_along_x() { return {{{2, 20, 20}}, {{32, 20, 20}}, 5, 0}; }

CriticalStructure values(double low, double high) {
  CriticalStructure one;
  one.name = "bone";
  one.values = CriticalStructure::Values{low, high};
  return one;
}

CriticalStructure sphere(const Eigen::Vector3d& centre, double radius) {
  CriticalStructure one;
  one.name = "gall bladder";
  one.sphere = CriticalStructure::Sphere{{centre}, radius};
  return one;
}

TEST(CriticalStructuresTest, MeasuresLengthAndAngleOfThePath) {
  const Volume ct = cube_with_voxel(0, 0, 0);
  EXPECT_DOUBLE_EQ(check_path(path_along_x(), {}, ct).length_mm, 30);
  EXPECT_DOUBLE_EQ(check_path(path_along_x(), {}, ct).angle_to_axial_rad, 0);
  const NeedlePlan steep{{{0, 0, 0}}, {{0, 3, 3}}, 5, 0};
  EXPECT_NEAR(check_path(steep, {}, ct).angle_to_axial_rad, M_PI / 4, 1e-12);
}

TEST(CriticalStructuresTest, FindsTheDistanceOfTheNearestVoxelFromThePath) {
  // Beside the middle of the path: 3 mm and 4 mm away along two axes.
  const auto beside = check_path(path_along_x(), {values(400, 600)}, cube_with_voxel(15, 23, 24));
  ASSERT_EQ(beside.clearances.size(), 1U);
  ASSERT_TRUE(beside.clearances[0].distance_mm);
  EXPECT_NEAR(*beside.clearances[0].distance_mm, 5, 1e-12);
  EXPECT_FALSE(beside.clearances[0].too_near) << "5 mm is not nearer than 5 mm";
  EXPECT_NEAR((beside.clearances[0].nearest_ct.mm - Eigen::Vector3d(15, 23, 24)).norm(), 0, 1e-12);
  // Behind the target: the path ends there.
  const auto behind = check_path(path_along_x(), {values(400, 600)}, cube_with_voxel(36, 20, 23));
  EXPECT_NEAR(*behind.clearances[0].distance_mm, 5, 1e-12);
  const auto on = check_path(path_along_x(), {values(400, 600)}, cube_with_voxel(20, 20, 20));
  EXPECT_NEAR(*on.clearances[0].distance_mm, 0, 1e-12);
  EXPECT_TRUE(on.clearances[0].too_near);
  EXPECT_FALSE(check_path(path_along_x(), {values(700, 900)}, cube_with_voxel(20, 20, 20))
                   .clearances[0]
                   .distance_mm);
}

TEST(CriticalStructuresTest, ASphereIsMeasuredToItsSurface) {
  const Volume ct = cube_with_voxel(0, 0, 0);
  const auto check =
      check_path(path_along_x(), {sphere({10, 30, 20}, 4), sphere({10, 21, 20}, 4)}, ct);
  EXPECT_NEAR(*check.clearances[0].distance_mm, 6, 1e-12);
  EXPECT_NEAR(*check.clearances[1].distance_mm, -3, 1e-12);
  EXPECT_FALSE(check.clearances[0].too_near);
  EXPECT_TRUE(check.clearances[1].too_near);
}

TEST(CriticalStructuresTest, RejectsBothKindsNeitherAndNamesThatComeTwice) {
  CriticalStructure both = sphere({0, 0, 0}, 1);
  both.values = CriticalStructure::Values{0, 1};
  EXPECT_THAT(validate({both}).error().message, HasSubstr("found both"));
  CriticalStructure neither;
  neither.name = "x";
  EXPECT_THAT(validate({neither}).error().message, HasSubstr("found neither"));
  EXPECT_THAT(validate({values(0, 1), values(2, 3)}).error().message,
              HasSubstr("critical_structures[1].name: expected a name of its own"));
  EXPECT_THAT(validate({values(3, 3)}).error().message, HasSubstr(".high_hu: expected more"));
  EXPECT_TRUE(validate({values(0, 1), sphere({0, 0, 0}, 1)}));
}

}  // namespace
}  // namespace nav::session
