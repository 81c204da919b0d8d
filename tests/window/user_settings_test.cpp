// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/user_settings.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

TEST(UserSettingsTest, ComeBackFromTheirFile) {
  const test::TemporaryFolder folder;
  const auto first = read_user_settings(folder / "sonde");
  ASSERT_TRUE(test::has_value(first)) << "a new user has no file";
  EXPECT_EQ(first->text_scale, 1);
  ASSERT_TRUE(test::has_value(write_user_settings({.text_scale = 1.75}, folder / "sonde")));
  const auto next = read_user_settings(folder / "sonde");
  ASSERT_TRUE(test::has_value(next));
  EXPECT_EQ(next->text_scale, 1.75);
  EXPECT_EQ(read_user_settings({})->text_scale, 1) << "without a folder";
}

TEST(UserSettingsTest, ADamagedFileIsNamed) {
  const test::TemporaryFolder folder;
  for (const auto& [text, part] :
       {std::pair("text_scale = 7.0\n", "found 7"), std::pair("text_scale = 'x'\n", "text_scale"),
        std::pair("text_scale = nan\n", "from 1 to 2"), std::pair("colour = 1\n", "found colour"),
        std::pair("text_scale = \n", "line 1")}) {
    std::ofstream(folder / "window.toml") << text;
    const auto read = read_user_settings(folder.path());
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().code, ErrorCode::kMalformedData);
    EXPECT_NE(read.error().message.find("window.toml"), std::string::npos);
    EXPECT_NE(read.error().message.find(part), std::string::npos) << read.error().message;
  }
}

TEST(UserSettingsTest, AFolderThatCannotBeMadeIsNamed) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "sonde") << "a file";
  const auto written = write_user_settings({}, folder / "sonde");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
  EXPECT_NE(written.error().message.find("sonde"), std::string::npos);
}

}  // namespace
}  // namespace nav::app
