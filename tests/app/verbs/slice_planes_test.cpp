// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/slice_planes.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav::app {
namespace {

using Vec = Eigen::Vector3d;
constexpr double kRoundingPx = 1e-9;

/// CT of 60 x 40 x 90 mm around the origin.
Volume ct() {
  VoxelGrid grid;
  grid.size = {30, 20, 30};
  grid.spacing_mm = {2, 2, 3};
  grid.origin_mm = {-29, -19, -43.5};
  return *Volume::create(grid, std::vector<std::int16_t>(grid.voxel_count()), "box");
}

/// Largest distance of a corner of the CT from the middle of the image, pixels.
double reach_px(const Volume& volume, const NamedPlane& slice) {
  const Vec half = 0.5 * volume.grid().extent_mm();
  double most = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec sign((corner & 1) * 2 - 1, (corner >> 1 & 1) * 2 - 1, (corner >> 2) * 2 - 1);
    const Vec from = volume.grid().centre().mm + half.cwiseProduct(sign) - slice.plane.centre_ct.mm;
    for (const Vec& axis : {slice.plane.right.v, slice.plane.down.v}) {
      most = std::max(most, std::abs(from.dot(axis)) / slice.mm_per_pixel);
    }
  }
  return most;
}

TEST(SlicePlanesTest, TheCtFitsAroundAnyPointAtOneScale) {
  const Volume volume = ct();
  SlicesOptions options;
  options.size_px = 200;
  options.normal_ct = Vec(1, 2, 3);
  for (const Vec& at : {Vec(0, 0, 0), Vec(25, 0, 0), Vec(-20, 15, 40), Vec(0, -19, -44)}) {
    options.at_ct = at;
    const auto planes = slice_planes(options, {}, volume, {});
    ASSERT_TRUE(test::has_value(planes));
    ASSERT_EQ(planes->size(), 4U);
    double most = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ((*planes)[i].mm_per_pixel, planes->front().mm_per_pixel);
      most = std::max(most, reach_px(volume, (*planes)[i]));
    }
    EXPECT_NEAR(most, 100, kRoundingPx) << at.transpose() << ": fits, and no smaller than that";
    EXPECT_NEAR(reach_px(volume, (*planes)[3]), 100, 20) << (*planes)[3].name;
  }
  options.at_ct = Vec(0, 0, 0);
  EXPECT_DOUBLE_EQ(slice_planes(options, {}, volume, {})->front().mm_per_pixel, 90.0 / 200);
  options.mm_per_pixel = 0.7;
  const auto given = slice_planes(options, {}, volume, {});
  for (const NamedPlane& slice : *given) {
    EXPECT_EQ(slice.mm_per_pixel, 0.7) << slice.name;
  }
}

}  // namespace
}  // namespace nav::app
