// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/console.hpp"

#include <gtest/gtest.h>

#include "app/report.hpp"

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
  testing::internal::CaptureStderr();
  console.say_suppressed();
  const std::string suppressed = testing::internal::GetCapturedStderr();
  EXPECT_NE(suppressed.find("sonde: 95 more like this: pose at 0.080000 s"), std::string::npos)
      << suppressed;
  EXPECT_NE(suppressed.find("sonde: 1 more like this: another kind"), std::string::npos);
}

TEST(ConsoleTest, ShowsOneLineForEachKindOfFinding) {
  Console console(false);
  testing::internal::CaptureStderr();
  for (int i = 0; i < 10; ++i) {
    console.report("recording", {.subject = "a.mha",
                                 .key = "position of the probe",
                                 .values = {"one", "another in frame " + std::to_string(i)},
                                 .used = "one"});
  }
  console.say_suppressed();
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 2) << said;
  EXPECT_NE(said.find("warning: recording: a.mha: position of the probe: one against another in "
                      "frame 0; used: one\n"),
            std::string::npos)
      << said;
  EXPECT_NE(said.find("9 more like this"), std::string::npos);
  io::Json report;
  add_messages(report, console.entries());
  ASSERT_EQ(report["findings"].size(), 1U);
  EXPECT_EQ(report["findings"][0]["key"], "position of the probe");
  EXPECT_EQ(report["findings"][0]["values"][1], "another in frame 0");
  EXPECT_EQ(report["findings"][0]["used"], "one");
  EXPECT_EQ(report["findings"][0]["severity"], "warning");
  EXPECT_EQ(report["findings"][0]["count"], 10);
  EXPECT_EQ(report["diagnostics"][0]["count"], 10);
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

TEST(ConsoleTest, ShortensContentsOfFiles) {
  const std::string path(200, 'p');
  EXPECT_EQ(for_terminal(path + ": found x\n"), path + ": found x\\n");
  const std::string shown = for_terminal("a.json: found " + std::string(100000, 'A') + "end more");
  EXPECT_EQ(shown,
            "a.json: found " + std::string(100, 'A') + "…" + std::string(36, 'A') + "end more");
  // A character that is cut in two is shown as its bytes.
  const std::string cut = for_terminal("x" + std::string(400, '\xc3') + "end");
  EXPECT_LT(cut.size(), 700U);
  EXPECT_EQ(for_terminal(""), "");
}

}  // namespace
}  // namespace nav::app
