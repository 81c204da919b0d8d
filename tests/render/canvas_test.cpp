// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/canvas.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace nav::render {
namespace {

constexpr int kSize = 16;

/// Number of pixels that a text colours in an image of \p width, starting at \p x.
std::ptrdiff_t inked(int width, int x) {
  Canvas canvas(width, 40, rgb8(0));
  EXPECT_EQ(canvas.text(x, 24, kSize, "12.5 mm", rgb8(0xffffff)),
            x + canvas.text_width(kSize, "12.5 mm"));
  const auto image = canvas.image();
  return std::ranges::count_if(image.pixels(), [](const Rgba8& p) { return p.r > 0; });
}

TEST(CanvasTest, TextThatDoesNotFitIsLeftOutCompletely) {
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

/// Pixels of a text.
std::vector<std::uint8_t> ink_of(const std::string& words) {
  Canvas canvas(200, 40, rgb8(0));
  canvas.text(4, 30, kSize, words, rgb8(0xffffff));
  std::vector<std::uint8_t> ink;
  const auto image = canvas.image();
  for (const Rgba8& p : image.pixels()) ink.push_back(p.r);
  return ink;
}

TEST(CanvasTest, DrawsTheLettersOfLatinAlphabets) {
  const std::string letters = "äöüßàâçéèêëîïôûùœÄÖÜÀÉåøæñáíóúčďěňřšťůýžąćęłńśźżğışőű°µ±×€";
  EXPECT_TRUE(letters_not_drawn(letters).empty());
  for (const Letter& letter : letters_of(letters)) {
    EXPECT_NE(ink_of("l" + letter.bytes + "l"), ink_of("ll")) << letter.bytes;
    EXPECT_NE(ink_of("l" + letter.bytes + "l"), ink_of("l?l")) << letter.bytes;
  }
  EXPECT_NE(ink_of("Gefäß"), ink_of("Gefas"));
}

TEST(CanvasTest, DrawsUnknownLettersAsQuestionMarks) {
  for (const char* letter : {"中", "Ж", "→", "\t", "\n", "\xff", "\xe4", "\U0001F600"}) {
    EXPECT_EQ(ink_of(std::string("l") + letter + "l"), ink_of("l?l")) << letter;
  }
  const auto missing = letters_not_drawn("中a中äЖ ?");
  ASSERT_EQ(missing.size(), 2U);
  EXPECT_EQ(missing[0].bytes, "中");
  EXPECT_EQ(missing[1].code, char32_t{0x416});
}

}  // namespace
}  // namespace nav::render
