// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/overlay.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "app/views/panels.hpp"

namespace nav::app {
namespace {

TEST(OverlayTest, LettersAgreeWithTheAxesOfTheSlice) {
  const Point<frames::Ct> at{{0, 0, 0}};
  for (const render::SlicePlane& plane :
       {render::axial_slice(at), render::coronal_slice(at), render::sagittal_slice(at)}) {
    const auto letters = render::labels_of(plane);
    EXPECT_EQ(letters.right, patient_direction(plane.right.v));
    EXPECT_EQ(letters.left, patient_direction(-plane.right.v));
    EXPECT_EQ(letters.bottom, patient_direction(plane.down.v));
    EXPECT_EQ(letters.top, patient_direction(-plane.down.v));
  }
}

TEST(OverlayTest, PositionsHaveTheLetterOfTheirSign) {
  EXPECT_EQ(position_words({12, -34.54, 6.06}), "at L 12.0  A 34.5  S 6.1 mm");
  EXPECT_EQ(position_words({-1, 2, -3}), "at R 1.0  P 2.0  I 3.0 mm");
  EXPECT_EQ(position_words({-0.01, -0.01, 0.01}), "at L 0.0  P 0.0  S 0.0 mm") << "no minus zero";
}

/// Longest run of pixels of a colour in a row.
int longest_run(const render::Canvas& canvas, Rgba8 colour) {
  const auto image = canvas.image();
  int longest = 0;
  for (int y = 0; y < image.height(); ++y) {
    int run = 0;
    for (int x = 0; x < image.width(); ++x) {
      run = image.at(x, y) == colour ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  return longest;
}

TEST(OverlayTest, TheScaleBarIsAsLongAsItSays) {
  constexpr Rgba8 kRed{255, 0, 0, 255};
  // A fifth of 400 pixels of 0.5 mm is 40 mm, so the bar has 20 mm.
  render::Canvas canvas(400, 60, render::rgb8(0));
  draw_scale_bar(canvas, {0, 0, 400, 60}, 10, 40, 0.5, 14, kRed);
  EXPECT_NEAR(longest_run(canvas, kRed), 40, 3);
  // 4 mm a pixel: a fifth is 320 mm, so the bar has 200 mm.
  render::Canvas coarse(400, 60, render::rgb8(0));
  draw_scale_bar(coarse, {0, 0, 400, 60}, 10, 40, 4, 14, kRed);
  EXPECT_NEAR(longest_run(coarse, kRed), 50, 3);
}

TEST(OverlayTest, OutlinedTextIsDarkAroundItsInkOnWhite) {
  render::Canvas plain(80, 40, render::rgb8(0xffffff));
  render::Canvas outlined(80, 40, render::rgb8(0xffffff));
  plain.text(10, 28, 16, "A", render::rgb8(0xffffff));
  outlined.outlined_text(10, 28, 16, "A", render::rgb8(0xffffff));
  const auto dark = [](const render::Canvas& canvas) {
    const auto image = canvas.image();
    return std::ranges::count_if(image.pixels(), [](const Rgba8& p) { return p.r < 100; });
  };
  EXPECT_EQ(dark(plain), 0) << "white on white cannot be read";
  EXPECT_GT(dark(outlined), 20);
}

TEST(OverlayTest, TextGrowsWithTheImage) {
  EXPECT_EQ(text_size(13, 300), 13);
  EXPECT_EQ(text_size(13, 600), 13);
  EXPECT_EQ(text_size(13, 1200), 26);
}

}  // namespace
}  // namespace nav::app
