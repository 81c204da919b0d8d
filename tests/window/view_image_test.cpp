// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/view_image.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "render/quality/progressive.hpp"

namespace nav::app {
namespace {

/// A window shows the same bytes as a file of the same image.
TEST(ViewImageTest, RoundsAsTheHeadlessImagesDo) {
  std::vector<RgbaF> pixels;
  const auto add = [&](float x) { pixels.push_back({x, 1 - x, x, 1}); };
  for (int i = 0; i <= 510; ++i) {
    const float edge = static_cast<float>(i) / 510.0F;
    for (const float x : {std::nextafter(edge, -1.0F), edge, std::nextafter(edge, 2.0F)}) add(x);
  }
  for (const float x : {-1.0F, 2.0F, std::numeric_limits<float>::infinity()}) add(x);
  std::mt19937 random(7);
  while (pixels.size() < 4096) add(static_cast<float>(random()) / 4294967295.0F);
  const Image2d<RgbaF> image(64, 64, pixels);
  EXPECT_EQ(to_rgb32(image), to_rgb32(render::to_8bit(image)));
}

TEST(ViewImageTest, AnImageWithFewerPixelsIsEnlargedAsTheRendererDoesIt) {
  constexpr int kWidth = 86, kHeight = 61;
  std::vector<RgbaF> pixels;
  for (int i = 0; i < 11 * 8; ++i) {
    pixels.push_back({0.01F * static_cast<float>(i), 0.5F, 1 - 0.01F * static_cast<float>(i), 1});
  }
  const render::RenderedImage coarse{{11, 8, std::move(pixels)}, {}};
  const QImage expected = to_rgb32(render::enlarged(coarse, kWidth, kHeight).pixels);
  EXPECT_EQ(to_rgb32(coarse.pixels, {kWidth, kHeight}), expected);
  EXPECT_EQ(to_rgb32(coarse.pixels, {11, 8}), to_rgb32(coarse.pixels));
}

}  // namespace
}  // namespace nav::app
