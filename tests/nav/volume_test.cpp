// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/volume.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/support/matchers.hpp"

namespace nav {
namespace {

constexpr double kIndexRounding = 1e-9;

VoxelGrid oblique_grid() {
  VoxelGrid grid;
  grid.size = {5, 4, 3};
  grid.spacing_mm = {0.5, 1.25, 4.0};
  grid.origin_mm = {-100, 20, 1e5};
  grid.directions =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  grid.directions.col(2) *= -1;  // Left-handed.
  return grid;
}

Volume ramp(const VoxelGrid& grid) {
  std::vector<std::int16_t> hu;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        hu.push_back(static_cast<std::int16_t>(3 * i + 50 * j - 700 * k));
  return *Volume::create(grid, std::move(hu), "ramp");
}

TEST(VoxelGridTest, IndexOfInvertsAt) {
  const VoxelGrid grid = oblique_grid();
  const Eigen::Vector3d index(1.5, -2.25, 7);
  EXPECT_LT((grid.index_of(grid.at(index)) - index).norm(), kIndexRounding);
}

TEST(VolumeTest, TrilinearInterpolationReproducesALinearField) {
  const Volume volume = ramp(oblique_grid());
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int n = 0; n < 1000; ++n) {
    const Eigen::Vector3d index(4 * unit(random), 3 * unit(random), 2 * unit(random));
    const auto value = volume.sample(volume.grid().at(index));
    ASSERT_TRUE(value);
    ASSERT_NEAR(*value, 3 * index.x() + 50 * index.y() - 700 * index.z(), 1e-6);
  }
}

TEST(VolumeTest, HasValuesUpToItsBorderAndNoneOutside) {
  const Volume volume = ramp(oblique_grid());
  EXPECT_TRUE(volume.sample(volume.grid().at({0, 0, 0})));
  EXPECT_TRUE(volume.sample(volume.grid().at({4, 3, 2})));
  EXPECT_FALSE(volume.sample(volume.grid().at({4.001, 3, 2})));
  EXPECT_FALSE(volume.sample(volume.grid().at({-0.001, 0, 0})));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(volume.sample({{nan, 0, 0}}));
}

TEST(VolumeTest, AcceptsASingleSlice) {
  VoxelGrid grid;
  grid.size = {2, 2, 1};
  const auto volume = Volume::create(grid, {1, 2, 3, 4}, "slice");
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_NEAR(*volume->sample({{0.5, 0.5, 0}}), 2.5, kIndexRounding);
}

TEST(VolumeTest, RejectsEachInvalidGridAndNamesTheDefect) {
  const auto refused = [](auto change) {
    VoxelGrid grid;
    grid.size = {2, 2, 2};
    change(grid);
    return Volume::create(grid, std::vector<std::int16_t>(8), "head.nrrd");
  };
  using Code = ErrorCode;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(test::rejects(refused([](VoxelGrid& g) { g.size[1] = 0; }), Code::kMalformedData,
                            {"head.nrrd", "axis 1", "0"}));
  EXPECT_TRUE(test::rejects(refused([](VoxelGrid& g) { g.spacing_mm.z() = -2; }),
                            Code::kMalformedData, {"head.nrrd", "spacing", "axis 2", "-2"}));
  EXPECT_TRUE(test::rejects(refused([](VoxelGrid& g) { g.spacing_mm.x() = 1e30; }),
                            Code::kMalformedData, {"spacing", "1e+30"}));
  EXPECT_TRUE(test::rejects(refused([&](VoxelGrid& g) { g.spacing_mm.x() = nan; }),
                            Code::kMalformedData, {"spacing", "nan"}));
  EXPECT_TRUE(test::rejects(refused([&](VoxelGrid& g) { g.origin_mm.y() = nan; }),
                            Code::kMalformedData, {"origin"}));
  EXPECT_TRUE(test::rejects(refused([](VoxelGrid& g) { g.directions(0, 0) = 0.9; }),
                            Code::kMalformedData, {"orthonormal"}));
  EXPECT_TRUE(test::rejects(refused([](VoxelGrid& g) {
                              g.size = {4096, 4096, 4096};
                            }),
                            Code::kMalformedData, {"2^31", "4096 x 4096 x 4096"}));
  EXPECT_TRUE(test::rejects(refused([](VoxelGrid& g) {
                              g.size = {3, 2, 2};
                            }),
                            Code::kMalformedData, {"12 voxels", "found 8"}));
}

}  // namespace
}  // namespace nav
