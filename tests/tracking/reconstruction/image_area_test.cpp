// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/reconstruction/image_area.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav::tracking {
namespace {

UltrasoundImage image_of(int width, int height) {
  UltrasoundImage image;
  image.grid = {Eigen::Vector2d(0.5, 0.25).asDiagonal(), {0, 0}};
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  image.pixels = Image2d<std::uint8_t>(width, height, std::vector<std::uint8_t>(count));
  return image;
}

TEST(ImageAreaTest, TakesTheWholeImageWithoutClip) {
  const ImageArea area(image_of(20, 10), {});
  EXPECT_EQ(area.pixel_count(), 200U);
  ASSERT_EQ(area.runs().size(), 10U);
  EXPECT_EQ(area.corners().back(), Eigen::Vector2d(19, 9));
  EXPECT_FALSE(area.apex());
}

TEST(ImageAreaTest, TakesBothEndsOfTheRectangleAsPlusDoes) {
  PlusClip clip;
  clip.rectangle = {{3.2, 2}, {10, 4}};
  const ImageArea area(image_of(20, 10), clip);
  EXPECT_EQ(area.runs().front().row, 2);
  EXPECT_EQ(area.runs().front().first, 4);
  EXPECT_EQ(area.runs().front().past, 14);
  EXPECT_EQ(area.runs().back().row, 6);
  clip.rectangle = {{-5, -5}, {100, 100}};
  EXPECT_EQ(ImageArea(image_of(20, 10), clip).pixel_count(), 200U);
  clip.rectangle = {{30, 0}, {10, 10}};
  EXPECT_TRUE(ImageArea(image_of(20, 10), clip).empty());
}

TEST(ImageAreaTest, CutsOutAFan) {
  PlusClip clip;
  clip.fan = {{10, -2}, -M_PI / 4, M_PI / 4, 5, 9};
  const ImageArea area(image_of(21, 10), clip);
  for (int row = 0; row < 10; ++row) {
    for (int column = 0; column < 21; ++column) {
      const double x = column - 10;
      const double y = row + 2;
      const bool inside = std::abs(x) <= y && x * x + y * y >= 25 && x * x + y * y <= 81;
      EXPECT_EQ(area.contains(column, row), inside) << column << ' ' << row;
    }
  }
  ASSERT_TRUE(area.apex());
  EXPECT_EQ(area.apex()->mm, Eigen::Vector2d(5, -0.5));
  EXPECT_DOUBLE_EQ(area.apex()->radius_mm, 1.25);
}

TEST(ImageAreaTest, SplitsRowsOfASectorAroundItsFace) {
  UltrasoundImage image = image_of(41, 40);
  image.outline = SectorOutline{{10, -1}, 4, 9, 1.0};
  const ImageArea area(image, {});
  std::size_t pixels = 0;
  int split = 0;
  for (std::size_t n = 0; n < area.runs().size(); ++n) {
    const auto& run = area.runs()[n];
    if (n > 0 && area.runs()[n - 1].row == run.row) ++split;
    for (int column = run.first; column < run.past; ++column) {
      EXPECT_TRUE(image.outline->contains(image.grid.at(column, run.row).mm.head<2>()));
      ++pixels;
    }
  }
  EXPECT_EQ(pixels, area.pixel_count());
  EXPECT_GT(split, 3);
  EXPECT_TRUE(area.fits(image));
  image.outline->radius_max_mm = 8;
  EXPECT_FALSE(area.fits(image));
}

TEST(ImageAreaTest, RejectsClipsWithoutExtent) {
  PlusClip clip;
  clip.rectangle = {{0, 0}, {0, 5}};
  EXPECT_TRUE(test::rejects(validate(clip), ErrorCode::kUsage, {"clip rectangle", "0 0 0 5"}));
  clip.rectangle.reset();
  clip.fan = {{0, 0}, 0.5, -0.5, 1, 2};
  EXPECT_TRUE(test::rejects(validate(clip), ErrorCode::kUsage, {"fan", "increasing"}));
  clip.fan = {{0, NAN}, -0.5, 0.5, 1, 2};
  EXPECT_FALSE(validate(clip));
}

}  // namespace
}  // namespace nav::tracking
