// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/console.hpp"

#include <gtest/gtest.h>

namespace nav::app {
namespace {

TEST(ConsoleTest, ShowsFiveMessagesThatDifferInTheirNumbersOnly) {
  Console console(false);
  testing::internal::CaptureStderr();
  for (int i = 0; i < 100; ++i) {
    console.report(Severity::kWarning, "gate",
                   "pose at " + std::to_string(0.02 * i) + " s: expected 15 ms, found 90 ms");
  }
  console.report(Severity::kWarning, "gate", "another kind");
  console.report(Severity::kWarning, "gate", "another kind");
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 6) << said;
  EXPECT_NE(said.find("only counted"), std::string::npos);
  const auto entries = console.entries();
  ASSERT_EQ(entries.size(), 6U);
  std::size_t all = 0;
  for (const auto& entry : entries) all += entry.count;
  EXPECT_EQ(all, 102U);
  EXPECT_EQ(entries[4].count, 96U);
}

TEST(ConsoleTest, ShowsControlCharactersOfFilesEscaped) {
  EXPECT_EQ(without_controls("a\x1b[2Jb\nc\x7f"), "a\\x1b[2Jb\\nc\\x7f");
  EXPECT_EQ(without_controls("\xc2\x9b"
                             "5A"),
            "\\xc2\\x9b5A")
      << "CSI of eight bits";
  EXPECT_EQ(without_controls("\xff\xc3"), "\\xff\\xc3") << "no UTF-8";
  EXPECT_EQ(without_controls("L\xc3\xa4sion \xe2\x82\xac"), "L\xc3\xa4sion \xe2\x82\xac");
}

}  // namespace
}  // namespace nav::app
