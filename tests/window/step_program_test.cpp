// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The steps that act, with the built program.
#include <cstdlib>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <sys/wait.h>

#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

using ::testing::HasSubstr;

class StepProgramTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::string file(const std::string& name) const {
    return (folder_ / name).string();
  }
  [[nodiscard]] std::string text_of(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(folder_ / name).rdbuf();
    return text.str();
  }
  [[nodiscard]] std::string log() const { return text_of("log"); }
  [[nodiscard]] int run(const std::string& arguments, const std::string& script) const {
    std::ofstream(folder_ / "script.txt") << script;
    const std::string command =
        "XDG_STATE_HOME=" + file("state") + " QT_QPA_PLATFORM=offscreen " SONDE_WINDOW " " +
        arguments + " --engine cpu --shots " + file("shots") + " --json " + file("report.json") +
        " --script " + file("script.txt") + " >" + file("log") + " 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  /// A recorded sweep and its CT, as a session file.
  void make_recording() const {
    const std::string simulate = std::string(SONDE_PROGRAM) + " simulate --out " +
                                 file("sweep.igs.mha") + " --ct " + file("ct.mha") + " >" +
                                 file("log") + " 2>&1";
    ASSERT_EQ(std::system(simulate.c_str()), 0) << log();
    std::ofstream(folder_ / "a.toml") << "[source]\nrecording = \"sweep.igs.mha\"\n"
                                         "[ct]\npath = \"ct.mha\"\n";
  }
  test::TemporaryFolder folder_;
};

TEST_F(StepProgramTest, APlanIsMadeByClicksAndCheckedAgainstStructures) {
  ASSERT_EQ(run("--simulated",
                "wait session running 60\nwait view.view3d shown 60\nkey F5\n"
                "wait plan.state clear 10\nclick plan-add-sphere\nwait plan.state too-near 10\n"
                "expect plan.structures 1\nkey Ctrl+Z\nwait plan.state clear 10\n"
                "expect plan.structures 0\nkey 2\nwait view.coronal shown 20\n"
                "click plan-pick-entry\nclick coronal\nwait plan.state clear 10\n"
                "click plan-pick-target\nkey Esc\nset plan-low 300\nclick plan-add-values\n"
                "wait plan.structures 1 5\nkey F7\ntype session-path " +
                    file("p.toml") + "\nclick session-save\nwait saved yes 10\n"),
            0)
      << log();
  EXPECT_THAT(text_of("p.toml"), HasSubstr("[[critical_structures]]"));
  EXPECT_THAT(text_of("p.toml"), HasSubstr("entry_mm"));
}

TEST_F(StepProgramTest, APlacementByEyeIsDegradedAndReopens) {
  ASSERT_EQ(run("--simulated",
                "wait session running 60\nwait view.view3d shown 60\nwait state.CT valid 20\n"
                "key F4\nchoose overlay blend\nclick eye\nclick eye-left\nkey Ctrl+Up\n"
                "wait registration waiting 10\nwait state.CT degraded 10\n"
                "click registration-accept\nexpect registration waiting\n"
                "click registration-confirm\nwait registration accepted 5\n"
                "expect numeral.tip withdrawn 5\nkey F7\ntype session-path " +
                    file("p.toml") + "\nclick session-save\nwait saved yes 10\n"),
            0)
      << log();
  EXPECT_THAT(text_of("p.toml"), HasSubstr("verdict = 'accepted'"));
  const std::string first = text_of("p.toml");
  ASSERT_EQ(run(file("p.toml"),
                "wait session running 60\nwait state.CT degraded 30\nkey Ctrl+S\n"
                "wait saved yes 10\n"),
            0)
      << log();
  EXPECT_EQ(text_of("p.toml"), first);
}

TEST_F(StepProgramTest, ARejectedRegistrationIsDegradedAndStaysSo) {
  ASSERT_EQ(run("--simulated",
                "wait session running 60\nwait state.CT valid 30\nkey F4\n"
                "click registration-reject\nexpect state.CT valid\nclick registration-no\n"
                "click registration-reject\nclick registration-confirm\n"
                "wait state.CT degraded 10\nwait numeral.tip withdrawn 5\nkey F7\n"
                "type session-path " +
                    file("p.toml") + "\nclick session-save\nwait saved yes 10\n"),
            0)
      << log();
  EXPECT_THAT(text_of("p.toml"), HasSubstr("verdict = 'rejected'"));
  ASSERT_EQ(run(file("p.toml"), "wait session running 60\nwait state.CT degraded 30\n"), 0)
      << log();
}

TEST_F(StepProgramTest, ACancelledRegistrationLeavesEverythingAsItWas) {
  make_recording();
  ASSERT_EQ(run(file("a.toml"),
                "wait session running 60\nwait state.CT degraded 30\nkey F4\nclick register-sweep\n"
                "wait registration running 5\npause 1\nclick register-cancel\n"
                "wait registration none 0.5\nexpect job cancelled\nexpect state.CT degraded\n"),
            0)
      << log();
  EXPECT_THAT(text_of("report.json"), HasSubstr("\"cancelled\": true"));
  for (const auto& one : std::filesystem::directory_iterator(folder_ / "shots")) {
    EXPECT_EQ(one.path().extension(), ".sonde-lock") << one.path() << " was left";
  }
}

TEST_F(StepProgramTest, ACtIsReadInTheBackgroundAndABrokenOneLeavesTheOldOne) {
  make_recording();
  std::ofstream(folder_ / "broken.mha") << "not an image";
  std::filesystem::copy_file(folder_ / "ct.mha", folder_ / "other.mha");
  ASSERT_EQ(run(file("a.toml"),
                "wait session running 60\nwait view.view3d shown 60\nkey F1\ntype ct-path " +
                    file("broken.mha") +
                    "\nclick ct-open\nwait job failed 20\nexpect session running\n"
                    "wait view.view3d shown 20\npause 1\ntype ct-path " +
                    file("other.mha") +
                    "\nclick ct-open\nwait job done 60\npause 3\nexpect session running\nkey F7\n"
                    "type session-path " +
                    file("b.toml") + "\npause 1\nclick session-save\nwait saved yes 10\n"),
            0)
      << log();
  EXPECT_THAT(text_of("b.toml"), HasSubstr("other.mha"));
}

TEST_F(StepProgramTest, ACtAloneIsLookedAtPlannedOnAndReopens) {
  make_recording();
  ASSERT_EQ(
      run("",
          "expect session none\nkey F1\ntype ct-path " + file("broken.mha") +
              "\nclick ct-open\nwait job failed 20\ntype ct-path " + file("ct.mha") +
              "\npause 0.5\nclick ct-open\nwait session running 60\n"
              "wait view.axial shown 20\nwait view.view3d shown 60\nkey F2\nkey F5\n"
              "expect numeral.tip withdrawn\nclick plan-target\nwheel axial 8\n"
              "pause 0.5\nclick plan-entry\nwait plan.state clear 10\nkey F7\ntype session-path " +
              file("c.toml") + "\npause 1\nclick session-save\nwait saved yes 10\n"),
      0)
      << log();
  EXPECT_THAT(text_of("c.toml"), HasSubstr("ct.mha"));
  EXPECT_THAT(text_of("c.toml"), HasSubstr("recording = ''"));
  ASSERT_EQ(run(file("c.toml"),
                "wait session running 60\nwait view.view3d shown 60\nexpect state.volume valid\n"),
            0)
      << log();
}

TEST_F(StepProgramTest, ACtIsPlacedByDraggingInTheViews) {
  ASSERT_EQ(run("--simulated",
                "wait session running 60\nwait view.ultrasound shown 60\nwait state.CT valid 30\n"
                "drag ultrasound 20 10\nexpect registration none\nkey F4\n"
                "drag ultrasound 20 10\nexpect registration none\nclick eye\n"
                "drag ultrasound 20 10\nwait registration waiting 10\nwait state.CT degraded 10\n"
                "expect numeral.tip withdrawn 5\nkey F6\nkey F4\nkey Esc\nexpect panel step\n"),
            0)
      << log();
  ASSERT_EQ(run("--simulated",
                "wait session running 60\nwait state.CT valid 30\nwait view.view3d shown 60\n"
                "wait view.ultrasound shown 60\nwait state.ultrasound valid 30\n"
                "key F4\nclick eye\ndrag view3d 20 10\nwait registration waiting 10\n"
                "wait state.CT degraded 10\n"),
            0)
      << log();
}

TEST_F(StepProgramTest, TheDistanceToAStructureIsWithdrawnWithTheNeedle) {
  ASSERT_EQ(run("--simulated",
                "wait session running 60\nwait numeral.tip shown 60\n"
                "expect numeral.structure none\nkey F5\nclick plan-add-sphere\n"
                "wait numeral.structure shown 20\nfault cover-marker 2\n"
                "wait numeral.structure withdrawn 5\nexpect numeral.structure-error withdrawn\n"
                "wait numeral.structure shown 30\nkey Space\nwait numeral.structure withdrawn 1\n"),
            0)
      << log();
}

}  // namespace
}  // namespace nav::app
