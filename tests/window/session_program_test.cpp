// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Sessions as files, and recovery after a killed process, with the built program.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class SessionProgramTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::string file(const std::string& name) const {
    return (folder_ / name).string();
  }
  [[nodiscard]] static std::string text_of(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  [[nodiscard]] std::string log() const { return text_of(file("log")); }
  [[nodiscard]] std::string command(const std::string& arguments, const std::string& script) const {
    std::ofstream(file("script.txt")) << script;
    return "XDG_STATE_HOME=" + file("state") + " QT_QPA_PLATFORM=offscreen " SONDE_WINDOW " " +
           arguments + " --engine cpu --script " + file("script.txt") + " >" + file("log") +
           " 2>&1";
  }
  /// Exit code of the window with a script.
  [[nodiscard]] int run(const std::string& arguments, const std::string& script) const {
    const int status = std::system(command(arguments, script).c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  /// Starts the window in a process of its own.
  [[nodiscard]] pid_t start(const std::string& arguments, const std::string& script) const {
    const std::string whole = "exec env " + command(arguments, script);
    const pid_t child = ::fork();
    if (child == 0) {
      ::execl("/bin/sh", "sh", "-c", whole.c_str(), static_cast<char*>(nullptr));
      ::_exit(127);
    }
    return child;
  }
  static void kill_process(pid_t child) {
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
  }
  /// True once some window keeps unsaved changes that hold this text.
  [[nodiscard]] bool wait_for_recovery_file(const std::string& text) const {
    constexpr int kMostTries = 600;
    for (int i = 0; i < kMostTries; ++i) {
      std::error_code failed;
      for (std::filesystem::recursive_directory_iterator it(folder_ / "state", failed), end;
           !failed && it != end; it.increment(failed)) {
        if (it->path().filename() == "session.toml" &&
            text_of(it->path().string()).find(text) != std::string::npos) {
          return true;
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }
  [[nodiscard]] bool state_is_empty() const {
    std::error_code failed;
    return std::filesystem::is_empty(folder_ / "state" / "sonde" / "windows", failed) || failed;
  }
  test::TemporaryFolder folder_;
};

TEST_F(SessionProgramTest, ASavedSessionReopensAndIsSavedAsTheSameBytes) {
  const std::string saved = file("procedure.toml");
  ASSERT_EQ(run("--simulated",
                "wait session running 60\nwait view.view3d shown 60\npause 3\nexpect unsaved no\n"
                "key 2\nwait view.axial shown 20\ndrag view3d 60 20\nclick axial\n"
                "wheel axial 2 ctrl\ndrag coronal 40 10 right\ndrag sagittal 12 8 middle\n"
                "key F2\nclick second-slices\nclick second-view3d\n"
                "key T\nset transfer-opacity 0.4\nkey C\nset cutaway-theta1 0.3\n"
                "wait unsaved yes 10\nkey F7\ntype session-path " +
                    saved + "\nclick session-save\nwait saved yes 10\nexpect unsaved no 10\n"),
            0)
      << log();
  const std::string first = text_of(saved);
  EXPECT_THAT(first, HasSubstr("layout = 'slices'"));
  EXPECT_THAT(first, HasSubstr("eye_mm"));
  EXPECT_THAT(first, HasSubstr("cursor_mm"));
  EXPECT_THAT(first, HasSubstr("grey_width"));
  EXPECT_THAT(first, HasSubstr("theta1_deg"));
  EXPECT_THAT(first, HasSubstr("second_views = [ 'view3d', 'slices' ]"));
  EXPECT_THAT(first, HasSubstr("sonde_look"));
  EXPECT_TRUE(state_is_empty()) << "a saved session needs no recovery file";
  ASSERT_EQ(run(saved,
                "wait session running 60\nwait view.view3d shown 60\nexpect layout slices\n"
                "expect panel step\nexpect second-views view3d,slices\n"
                "expect unsaved no\nkey Ctrl+S\nwait saved yes 10\n"),
            0)
      << log();
  EXPECT_EQ(text_of(saved), first);
}

TEST_F(SessionProgramTest, AChangeInTheFirstMomentIsUnsaved) {
  ASSERT_EQ(run("--simulated",
                "wait session running 60\nexpect unsaved no\nkey 2\nwait unsaved yes 10\n"
                "key 1\nwait unsaved no 10\n"),
            0)
      << log();
}

TEST_F(SessionProgramTest, PredicatesAndScribblesReopen) {
  const std::string saved = file("phantom.toml");
  ASSERT_EQ(run("--phantom carotid",
                "wait predicates ready 120\nwait view.axial shown 20\nclick histogram.vessel\n"
                "drag histogram.vessel 0.9\nwait predicates ready 30\nclick scribble-show\n"
                "stroke axial show 0,0 4,2\nwait histogram.strokes 1 10\nwait predicates ready 30\n"
                "click scribble-show\nkey F7\ntype session-path " +
                    saved + "\nclick session-save\nwait saved yes 10\n"),
            0)
      << log();
  const std::string first = text_of(saved);
  EXPECT_THAT(first, HasSubstr("sonde_predicates"));
  EXPECT_THAT(first, HasSubstr("sonde_scribbles"));
  ASSERT_EQ(run(saved,
                "wait predicates ready 120\nexpect histogram.strokes 1\nexpect histogram.sum 1\n"
                "key Ctrl+S\nwait saved yes 10\n"),
            0)
      << log();
  EXPECT_EQ(text_of(saved), first);
}

TEST_F(SessionProgramTest, AFileThatSondeDidNotWriteStaysWithoutTheUsersWord) {
  const std::string own = file("own.toml");
  const std::string text = "# my notes\n[source]\nkind = \"simulated\"\n";
  std::ofstream(own) << text;
  ASSERT_EQ(run(own,
                "wait session running 60\nwait view.view3d shown 60\nkey 2\nkey Ctrl+S\n"
                "wait saved asks 10\nexpect step.1 done\nclick session-keep\nshot asks\n"),
            0)
      << log();
  EXPECT_EQ(text_of(own), text);
  ASSERT_EQ(run(own,
                "wait session running 60\nwait view.view3d shown 60\nkey 2\nkey Ctrl+S\n"
                "wait saved asks 10\nclick session-replace\nwait saved yes 10\n"),
            0)
      << log();
  EXPECT_THAT(text_of(own), HasSubstr("layout = 'slices'"));
}

TEST_F(SessionProgramTest, PathsInASavedSessionAreRelativeToIt) {
  const std::string simulate = std::string(SONDE_PROGRAM) + " simulate --out " +
                               file("sweep.igs.mha") + " --ct " + file("ct.mha") + " >" +
                               file("log") + " 2>&1";
  ASSERT_EQ(std::system(simulate.c_str()), 0) << log();
  std::filesystem::create_directories(folder_ / "sessions");
  std::ofstream(file("a.toml")) << "[source]\nrecording = \"sweep.igs.mha\"\n"
                                   "[ct]\npath = \"ct.mha\"\n";
  ASSERT_EQ(run(file("a.toml"),
                "wait session running 60\nwait view.view3d shown 60\nkey F7\ntype session-path " +
                    file("sessions/b.toml") + "\nclick session-save\nwait saved yes 10\n"),
            0)
      << log();
  const std::string saved = text_of(file("sessions/b.toml"));
  EXPECT_THAT(saved, HasSubstr("../ct.mha"));
  EXPECT_THAT(saved, HasSubstr("../sweep.igs.mha"));
  EXPECT_THAT(saved, Not(HasSubstr(folder_.path().string())));
}

TEST_F(SessionProgramTest, AKilledWindowIsRestoredByTheNext) {
  const pid_t child = start("--simulated",
                            "wait session running 60\nwait view.view3d shown 60\npause 3\n"
                            "drag view3d 50 0\nkey 3\npause 3600\n");
  const bool kept = wait_for_recovery_file("layout = 'needle'");
  kill_process(child);
  ASSERT_TRUE(kept) << log();
  ASSERT_EQ(run("",
                "wait recovery offered 20\nclick recovery-restore\n"
                "wait recovery restored 20\nwait session running 60\nwait layout needle 20\n"
                "expect unsaved yes 10\nkey F7\ntype session-path " +
                    file("restored.toml") + "\nclick session-save\nwait saved yes 10\n"),
            0)
      << log();
  EXPECT_THAT(text_of(file("restored.toml")), HasSubstr("layout = 'needle'"));
  EXPECT_THAT(text_of(file("restored.toml")), HasSubstr("eye_mm"));
  EXPECT_TRUE(state_is_empty());
}

TEST_F(SessionProgramTest, DiscardedChangesAreMovedAndNotLost) {
  const pid_t child = start("--simulated",
                            "wait session running 60\nwait view.view3d shown 60\npause 3\nkey 3\n"
                            "pause 3600\n");
  const bool kept = wait_for_recovery_file("layout = 'needle'");
  kill_process(child);
  ASSERT_TRUE(kept) << log();
  ASSERT_EQ(run("", "wait recovery offered 20\nclick recovery-discard\nwait recovery none 20\n"), 0)
      << log();
  EXPECT_TRUE(state_is_empty());
  int moved = 0;
  for (const auto& one :
       std::filesystem::directory_iterator(folder_ / "state" / "sonde" / "discarded")) {
    moved += text_of(one.path().string()).find("layout = 'needle'") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(moved, 1);
}

TEST_F(SessionProgramTest, AWindowThatIsOpenKeepsItsRecoveryFile) {
  const pid_t child = start("--simulated",
                            "wait session running 60\nwait view.view3d shown 60\npause 3\nkey 3\n"
                            "pause 3600\n");
  const bool kept = wait_for_recovery_file("layout = 'needle'");
  EXPECT_TRUE(kept) << log();
  EXPECT_EQ(run("", "pause 3\nexpect recovery none\n"), 0) << log();
  kill_process(child);
}

TEST_F(SessionProgramTest, ContradictionsAndUnknownKeysOfTheWindowAreNamedWithTheirLine) {
  struct Case {
    const char* text;
    const char* expected;
  };
  for (const Case& one :
       {Case{"[window]\nlayout = \"round\"\n", "window.layout: expected guidance"},
        Case{"[window]\nlayuot = \"slices\"\n", "bad.toml:2: unknown key 'window.layuot'"},
        Case{"[window]\nlayout = \"single\"\n", "window.layout: expected window.single"},
        Case{"[window]\nstep = 9\n", "window.step: expected"},
        Case{"[window]\nsecond_views = [\"axial\"]\n", "found axial"},
        Case{"[window]\nsecond_views = [\"slices\", \"slices\"]\n", "at most once"},
        Case{"[window.camera]\nfov_deg = 30.0\n", "window.camera: expected eye_mm"},
        Case{"[window]\ntransfer = \"{}\"\n", "bad.toml:2: window.transfer: expected"}}) {
    std::ofstream(file("bad.toml")) << one.text;
    EXPECT_NE(run(file("bad.toml"), "quit\n"), 0) << one.text;
    EXPECT_THAT(log(), HasSubstr(one.expected)) << one.text;
  }
}

}  // namespace
}  // namespace nav::app
