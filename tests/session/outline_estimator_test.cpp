// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/outline_estimator.hpp"

#include <gtest/gtest.h>

namespace nav::session {
namespace {

constexpr int kSide = 200;

SectorOutline sector() { return {{0, -20}, 20, 95, 0.5}; }

/// Bright inside the sector, or everywhere.
UltrasoundImage image(bool convex) {
  const PixelGrid grid = PixelGrid::centred(kSide, 0.5, 0.5);
  std::vector<std::uint8_t> pixels(kSide * kSide, 0);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const bool lit = !convex || sector().contains(grid.at(x, y).mm.head<2>());
      if (lit) pixels[static_cast<std::size_t>(y * kSide + x)] = 100;
    }
  }
  return {.pixels = Image2d<std::uint8_t>(kSide, kSide, std::move(pixels)), .grid = grid};
}

TEST(OutlineEstimatorTest, DecidesOnceAfterTwoEstimatesAgree) {
  OutlineEstimator estimator;
  const UltrasoundImage convex = image(true);
  for (int i = 0; i < 9; ++i) {
    estimator.add(convex);
    EXPECT_FALSE(estimator.outline()) << i;
  }
  estimator.add(convex);
  ASSERT_TRUE(estimator.outline());
  EXPECT_EQ(estimator.decided_after(), 10u);
  EXPECT_NEAR(estimator.outline()->half_angle_rad, sector().half_angle_rad, 0.02);
  EXPECT_NEAR(estimator.outline()->radius_max_mm, sector().radius_max_mm, 2);
  const double decided = estimator.outline()->half_angle_rad;
  for (int i = 0; i < 100; ++i) estimator.add(image(false));
  EXPECT_EQ(estimator.outline()->half_angle_rad, decided) << "what was decided stays";
}

TEST(OutlineEstimatorTest, FindsNoSectorInImagesOfALinearProbe) {
  OutlineEstimator estimator;
  for (int i = 0; i < 200; ++i) estimator.add(image(false));
  EXPECT_FALSE(estimator.outline());
  EXPECT_EQ(estimator.decided_after(), 80u);
}

}  // namespace
}  // namespace nav::session
