// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/letters.hpp"

#include <gtest/gtest.h>

namespace nav::render {
namespace {

using namespace std::string_literals;

TEST(LettersTest, EveryLengthOfUtf8IsOneLetter) {
  const auto letters = letters_of("aä中\U0001F600"s);
  ASSERT_EQ(letters.size(), 4U);
  const char32_t codes[] = {'a', 0xe4, 0x4e2d, 0x1f600};
  for (std::size_t n = 0; n < 4; ++n) {
    EXPECT_EQ(letters[n].bytes.size(), n + 1);
    EXPECT_EQ(letters[n].code, codes[n]);
  }
  EXPECT_TRUE(letters_of("").empty());
}

TEST(LettersTest, InvalidBytesAreSeparateLettersWithoutCode) {
  // Latin-1, cut short, overlong, a surrogate, beyond Unicode.
  for (const std::string& text :
       {"\xe4"s, "\xe4\xb8"s, "\xc0\x80"s, "\xe0\x80\x80"s, "\xed\xa0\x80"s, "\xf4\x90\x80\x80"s,
        "\xf0\x80\x80\x80"s, "\xff"s}) {
    const auto letters = letters_of(text + "z");
    ASSERT_EQ(letters.size(), text.size() + 1);
    for (std::size_t n = 0; n < text.size(); ++n) EXPECT_FALSE(letters[n].code.has_value());
    EXPECT_EQ(letters.back().code, U'z');
  }
}

TEST(LettersTest, RemovesTheLastLetterCompletely) {
  std::string text = "a中ä";
  drop_last_letter(text);
  EXPECT_EQ(text, "a中");
  drop_last_letter(text);
  EXPECT_EQ(text, "a");
}

}  // namespace
}  // namespace nav::render
