// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// No text of the window is cut: with the built program, at scales of the screen and of the texts.
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <sys/wait.h>

#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

class LayoutProgramTest : public ::testing::Test {
 protected:
  /// Runs a script at a scale of the screen. Returns what was said; empty: all lines were done.
  [[nodiscard]] std::string run(const std::string& arguments, const std::string& scale,
                                const std::string& script) const {
    const auto file = [&](const char* name) { return (folder_ / name).string(); };
    std::ofstream(folder_ / "script.txt") << script;
    const std::string command = "XDG_STATE_HOME=" + file("state") + " QT_SCALE_FACTOR=" + scale +
                                " QT_QPA_PLATFORM=offscreen " SONDE_WINDOW " " + arguments +
                                " --engine cpu --script " + file("script.txt") + " >" +
                                file("log") + " 2>&1";
    const int status = std::system(command.c_str());
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
    std::ostringstream text;
    text << std::ifstream(folder_ / "log").rdbuf();
    return text.str();
  }
  /// Opens each step and each panel, and expects all texts whole.
  [[nodiscard]] static std::string tour() {
    std::string script;
    for (int step = 1; step <= 7; ++step) {
      script += "key F" + std::to_string(step) + "\nexpect controls whole 2\n";
    }
    for (const char* key : {"P", "T", "C"}) {
      script += std::string("key ") + key + "\nexpect controls whole 2\n";
    }
    return script;
  }
  static constexpr const char* kLarger = "key Ctrl++\npause 0.2\nkey Ctrl++\npause 0.2\n";
  static constexpr const char* kAll = "expect text-scale 1.50\n";

  test::TemporaryFolder folder_;
};

TEST_F(LayoutProgramTest, NoTextIsCutAtAnyScale) {
  for (const char* scale : {"1", "1.25", "1.5", "2"}) {
    std::string script;
    for (const char* size : {"1280 800", "1600 900", "1920 1080"}) {
      script += std::string("resize ") + size + "\n" + tour();
    }
    EXPECT_EQ(run("", scale, script), "") << "scale " << scale;
  }
}

TEST_F(LayoutProgramTest, NoTextIsCutWithLargerFontsAndLongerTexts) {
  const std::string larger = std::string(kLarger) + kAll;
  EXPECT_EQ(run("", "1", "resize 1280 800\n" + larger + tour()), "") << "fonts + 50 %";
  EXPECT_EQ(run("", "1", "resize 1280 800\nlengthen\n" + tour()), "") << "texts + 40 %";
  EXPECT_EQ(run("", "2", "resize 1280 800\n" + larger + "lengthen\n" + tour()), "") << "both";
}

TEST_F(LayoutProgramTest, NoNumberIsCutBesideAStructure) {
  EXPECT_EQ(run("--simulated", "1",
                std::string("resize 1280 800\nwait numeral.tip shown 60\nkey F5\n"
                            "click plan-add-sphere\nwait numeral.structure shown 20\n") +
                    kLarger +
                    "wait numeral.tip shown 60\nexpect controls whole 5\n"
                    "fault cover-marker 2\nwait numeral.tip withdrawn 5\n"
                    "expect controls whole 2\n"),
            "");
}

TEST_F(LayoutProgramTest, ASecondScreenOpensAndCloses) {
  EXPECT_EQ(run("--simulated", "1",
                "wait view.ultrasound shown 60\nkey Ctrl+D\nwait second-screen shown 5\n"
                "pause 0.5\nexpect view.ultrasound shown 20\nkey F2\nclick second-slices\n"
                "expect second-views slices\npause 0.5\nexpect view.ultrasound shown 20\n"
                "expect view.axial hidden\nexpect controls whole 5\nkey Ctrl+D\n"
                "wait second-screen hidden 5\n"),
            "");
}

TEST_F(LayoutProgramTest, TheListOfControlsInTheDocumentIsTheWindows) {
  const std::filesystem::path page = folder_ / "window.md";
  std::filesystem::copy_file(SONDE_DOCS "/window.md", page);
  ASSERT_EQ(run("", "1", "controls " + page.string() + "\n"), "");
  const auto text_of = [](const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  };
  EXPECT_EQ(text_of(page), text_of(SONDE_DOCS "/window.md"))
      << "make it anew: a script with the line 'controls docs/window.md'";
}

}  // namespace
}  // namespace nav::app
