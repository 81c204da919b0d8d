// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/option_keys.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "app/options/session_config.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

TEST(OptionKeysTest, EveryKeyBelongsToTheSessionFile) {
  const test::TemporaryFolder folder;
  const auto path = folder / "session.toml";
  for (const auto& [key, option] : options_of_keys()) {
    std::ofstream(path) << key << " = 1979-05-27\n";  // No value is a date.
    const auto read = read_session_config(path);
    ASSERT_FALSE(read) << key;
    EXPECT_EQ(read.error().message.find("unknown key"), std::string::npos) << read.error().message;
    // The error quotes the value; for a key in a list's tables the list itself is rejected.
    EXPECT_NE(read.error().message.find("1979-05-27"), std::string::npos) << read.error().message;
  }
}

TEST(OptionKeysTest, AnErrorNamesTheGivenOption) {
  CLI::App verb;
  int width = 0;
  verb.add_option("--width", width);
  const Error about{ErrorCode::kUsage, "output.width_px: expected 64 to 8192, found 1"};
  const auto without = as_given(verb, about);
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().message, about.message);
  verb.parse("--width 1");
  const auto with = as_given(verb, about);
  ASSERT_FALSE(with);
  EXPECT_EQ(with.error().message, "--width (output.width_px): expected 64 to 8192, found 1");
}

}  // namespace
}  // namespace nav::app
