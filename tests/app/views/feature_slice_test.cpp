// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/feature_slice.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace nav::app {
namespace {

/// A feature of 20 × 30 × 40 voxels of 1 × 2 × 0.5 mm: 0 except a step along j, and undefined at
/// i = 0.
render::features::FeatureVolume stepped() {
  VoxelGrid grid;
  grid.size = {20, 30, 40};
  grid.spacing_mm = {1, 2, 0.5};
  auto values = std::make_shared<std::vector<float>>();
  for (int k = 0; k < 40; ++k) {
    for (int j = 0; j < 30; ++j) {
      for (int i = 0; i < 20; ++i) {
        values->push_back(i == 0 ? std::numeric_limits<float>::quiet_NaN() : j < 15 ? 0.0F : 1.0F);
      }
    }
  }
  return {grid, values};
}

int yellow(const Image2d<Rgba8>& image, int x0, int y0, int x1, int y1) {
  int count = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const Rgba8 p = image.at(x, y);
      count += p.r > 200 && p.g > 150 && p.b < 120 ? 1 : 0;
    }
  }
  return count;
}

FeatureSliceOptions options(int size_px) {
  return {.range = {.least = 0, .greatest = 1, .low = 0, .high = 1},
          .title = "step across k",
          .range_words = "0 to 1",
          .size_px = size_px};
}

TEST(FeatureSliceTest, PixelsAreSquareInMillimetres) {
  const auto image = feature_slice(stepped(), 2, options(480));
  EXPECT_EQ(image.height(), 480) << "60 mm along j";
  EXPECT_EQ(image.width(), 160) << "20 mm along i";
  // Undefined voxels are blue, the step is where it is.
  EXPECT_EQ(image.at(2, 300), (Rgba8{0, 0, 90, 255}));
  EXPECT_EQ(image.at(100, 200).r, 0);
  EXPECT_EQ(image.at(100, 280).r, 255);
}

TEST(FeatureSliceTest, LettersStandAtAllFourEdges) {
  for (const int size : {480, 1600}) {
    const auto image = feature_slice(stepped(), 0, options(size));
    const int w = image.width();
    const int h = image.height();
    const int edge = 60 * size / 480;
    EXPECT_GT(yellow(image, w / 2 - edge, 0, w / 2 + edge, edge), 10) << "top, " << size;
    EXPECT_GT(yellow(image, w / 2 - edge / 2, h - edge / 2, w / 2 + edge / 2, h), 10) << "bottom";
    EXPECT_GT(yellow(image, 0, h / 2 - edge / 2, edge, h / 2 + edge / 2), 10) << "left";
    EXPECT_GT(yellow(image, w - edge, h / 2 - edge / 2, w, h / 2 + edge / 2), 10) << "right";
  }
}

TEST(FeatureSliceTest, SmallImagesShowTheFeatureAlone) {
  const auto image = feature_slice(stepped(), 2, options(96));
  EXPECT_EQ(yellow(image, 0, 0, image.width(), image.height()), 0);
}

}  // namespace
}  // namespace nav::app
