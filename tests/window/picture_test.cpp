// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/picture.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "render/engine.hpp"

namespace nav::app {
namespace {

/// A window shows the same bytes as a file of the same image.
TEST(PictureTest, RoundsAsTheHeadlessImagesDo) {
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

}  // namespace
}  // namespace nav::app
