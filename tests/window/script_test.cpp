// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/script.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace nav::app {
namespace {

using ::testing::HasSubstr;

TEST(ScriptTest, ReadsCommandsAndLeavesOutComments) {
  const auto lines = parse_script("# a procedure\n\nkey F6\n  drag view3d +60 0\nquit\n");
  ASSERT_TRUE(lines) << lines.error().message;
  ASSERT_EQ(lines->size(), 3U);
  EXPECT_EQ((*lines)[1].number, 4);
  EXPECT_EQ((*lines)[1].command, "drag");
  EXPECT_EQ((*lines)[1].words, (std::vector<std::string>{"view3d", "+60", "0"}));
}

TEST(ScriptTest, NamesTheLineThatItCannotRead) {
  const auto unknown = parse_script("quit\nfly away\n");
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, HasSubstr("line 2: expected one of click"));
  EXPECT_THAT(unknown.error().message, HasSubstr("found 'fly'"));
  const auto few = parse_script("drag view3d\n");
  ASSERT_FALSE(few);
  EXPECT_THAT(few.error().message, HasSubstr("line 1: expected 'drag CONTROL DX DY"));
}

TEST(ScriptTest, NumbersHaveARange) {
  EXPECT_EQ(*script_number("+60", -100, 100), 60);
  for (const char* bad : {"", "+", "nan", "1e999", "7x", "101"}) {
    EXPECT_FALSE(script_number(bad, -100, 100)) << bad;
  }
}

TEST(ScriptTest, AnyBytesAreReadOrRejected) {
  std::mt19937 random(5);
  for (int run = 0; run < 2000; ++run) {
    std::string text(random() % 200, ' ');
    for (char& c : text) c = static_cast<char>(random());
    const auto lines = parse_script(text);
    EXPECT_TRUE(lines || lines.error().message.starts_with("line "));
  }
}

}  // namespace
}  // namespace nav::app
