// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/canvas.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace nav::render {
namespace {

constexpr int kSize = 16;

/// How many pixels a number inks in a picture of a width, from an x on.
std::ptrdiff_t inked(int width, int x) {
  Canvas canvas(width, 40, rgb8(0));
  EXPECT_EQ(canvas.text(x, 24, kSize, "12.5 mm", rgb8(0xffffff)),
            x + canvas.text_width(kSize, "12.5 mm"));
  const auto picture = canvas.picture();
  return std::ranges::count_if(picture.pixels(), [](const Rgba8& p) { return p.r > 0; });
}

TEST(CanvasTest, TextThatDoesNotFitIsLeftOutWhole) {
  const int wide = Canvas(1, 1, rgb8(0)).text_width(kSize, "12.5 mm");
  const auto whole = inked(200, 50);
  EXPECT_GT(whole, 50);
  EXPECT_EQ(inked(wide, 0), whole);
  EXPECT_EQ(inked(wide - 1, 0), 0);
  EXPECT_EQ(inked(200, -1), 0);
  EXPECT_EQ(inked(200, 200 - wide), whole);
  EXPECT_EQ(inked(200, 201 - wide), 0);
  EXPECT_EQ(inked(16, 8), 0);
}

}  // namespace
}  // namespace nav::render
