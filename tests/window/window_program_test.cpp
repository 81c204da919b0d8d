// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Runs the built program as a user does.
#include <cstdlib>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <sys/wait.h>

#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

using ::testing::HasSubstr;

class WindowProgramTest : public ::testing::Test {
 protected:
  void script(const std::string& text) const { std::ofstream(folder_ / "script.txt") << text; }
  /// Exit code of `sonde window` with the script.
  [[nodiscard]] int run(const std::string& arguments) const {
    const std::string command = "QT_QPA_PLATFORM=offscreen " SONDE_PROGRAM " window " + arguments +
                                " --script " + (folder_ / "script.txt").string() + " --json " +
                                (folder_ / "report.json").string() + " >" +
                                (folder_ / "log").string() + " 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  [[nodiscard]] std::string log() const {
    std::ostringstream text;
    text << std::ifstream(folder_ / "log").rdbuf();
    return text.str();
  }
  [[nodiscard]] nlohmann::json report() const {
    return nlohmann::json::parse(std::ifstream(folder_ / "report.json"));
  }
  test::TemporaryFolder folder_;
};

TEST_F(WindowProgramTest, TheReportHasEveryKey) {
  script(
      "wait view.ultrasound shown 60\nwait numeral.tip shown 30\ndrag view3d 40 10\npause 1\n"
      "fault cover-marker 1\nwait numeral.tip withdrawn 5\nwait view.ultrasound covered 5\n"
      "shot covered\nquit\n");
  ASSERT_EQ(run("--simulated --engine cpu --shots " + folder_.path().string()), 0) << log();
  const nlohmann::json json = report();
  for (const char* key : {"toolkit",
                          "platform",
                          "engine",
                          "device",
                          "device_pixel_ratio",
                          "refreshes",
                          "superseded",
                          "ledger",
                          "recordings",
                          "latency_ms",
                          "latency_independent_ms",
                          "input_to_paint_ms",
                          "handler_ms",
                          "longest_block_ms",
                          "paint_cpu_ms",
                          "convert_cpu_ms",
                          "withdrawn_after_ms",
                          "covered_after_ms",
                          "epochs_disagree",
                          "states",
                          "jobs",
                          "controls",
                          "costs",
                          "shots",
                          "diagnostics"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["epochs_disagree"], 0);
  EXPECT_EQ(json["engine"], "cpu");
  EXPECT_TRUE(json["ledger"]["balanced"].get<bool>());
  EXPECT_GT(json["refreshes"].get<int>(), 0);
  EXPECT_TRUE(json["withdrawn_after_ms"]["max"].is_number());
  EXPECT_EQ(json["shots"][0]["name"], "covered");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "covered.png"));
}

TEST_F(WindowProgramTest, ALineThatCannotBeDoneEndsWithItsNumberAndCause) {
  script("resize 800 600\nclick no-such-button\n");
  EXPECT_EQ(run(""), 5);
  EXPECT_THAT(log(), HasSubstr("line 2: click: expected a control's name, found 'no-such-button'"));
  script("resize 800 600\nfly\n");
  EXPECT_EQ(run(""), 5);
  EXPECT_THAT(log(), HasSubstr("line 2: expected one of click"));
  script("expect session running\n");
  EXPECT_EQ(run(""), 5);
  EXPECT_THAT(log(), HasSubstr("line 1: expect: expected session = running"));
}

TEST_F(WindowProgramTest, ASessionThatCannotBeOpenedIsNamedAndTheWindowStays) {
  std::ofstream(folder_ / "session.toml")
      << "[source]\nkind = \"recording\"\nrecording = \"none.mha\"\n[ct]\npath = \"none.nii\"\n";
  script("wait session failed 20\nexpect view.view3d covered\nkey F2\nshot failed\nquit\n");
  EXPECT_EQ(run((folder_ / "session.toml").string()), 0) << log();
}

/// A live session of a simulated device, as a user would start it.
class LiveWindowTest : public WindowProgramTest {
 protected:
  void SetUp() override {
    const std::string simulate = SONDE_PROGRAM " simulate --out " + file("sweep.igs.mha") +
                                 " --ct " + file("ct.mha") + " >" + file("log") + " 2>&1";
    ASSERT_EQ(std::system(simulate.c_str()), 0) << log();
    std::ofstream(folder_ / "live.toml")
        << "[source]\nkind = \"live\"\n[[devices]]\nid = \"bench\"\nkind = \"simulated\"\n"
           "needle = true\nduration_s = 3600\n";
  }
  [[nodiscard]] std::string file(const char* name) const { return (folder_ / name).string(); }
  /// Exit code of `sonde` with these words.
  [[nodiscard]] int sonde(const std::string& words) const {
    const std::string command =
        "QT_QPA_PLATFORM=offscreen " SONDE_PROGRAM " " + words + " >" + file("log") + " 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  [[nodiscard]] std::string live() const {
    return "live --session " + file("live.toml") + " --ct " + file("ct.mha") + " --window";
  }
};

TEST_F(LiveWindowTest, RecordsFromTheFirstSampleAndClosesAfterItsTime) {
  ASSERT_EQ(
      sonde(live() + " --seconds 2 --record " + file("r.mcap") + " --json " + file("report.json")),
      0)
      << log();
  const nlohmann::json json = report();
  ASSERT_EQ(json["recordings"].size(), 1U);
  const nlohmann::json& recording = json["recordings"][0];
  EXPECT_EQ(recording["path"], file("r.mcap"));
  EXPECT_GT(recording["written"].get<int>(), 20);
  EXPECT_EQ(recording["received"], recording["written"]);
  ASSERT_EQ(sonde("info " + file("r.mcap") + " --json " + file("info.json")), 0) << log();
  // An earlier recording is never overwritten, and the window does not open.
  EXPECT_EQ(sonde(live() + " --seconds 2 --record " + file("r.mcap")), 2);
  EXPECT_THAT(log(), HasSubstr("expected a file that does not exist"));
}

TEST_F(LiveWindowTest, ADeviceThatGivesNothingEndsWithTheExitCodeOfLive) {
  std::ofstream(folder_ / "live.toml", std::ios::app)
      << "[[devices]]\nid = \"silent\"\nkind = \"openigtlink\"\naddress = \"tcp:127.0.0.1:1\"\n"
         "bodies = [ {name = \"Stylus\"} ]\n";
  EXPECT_EQ(sonde(live() + " --seconds 2"), 4) << log();
  EXPECT_THAT(log(), HasSubstr("silent: expected samples of StylusToTracker, found none"));
}

TEST_F(LiveWindowTest, TheUserRecordsTwice) {
  script(
      "wait view.ultrasound shown 60\nexpect recording off\nkey Ctrl+R\nwait recording on 5\n"
      "pause 0.5\nkey Ctrl+R\nwait recording off 5\npause 0.2\nclick record\n"
      "wait recording on 5\npause 0.5\nquit\n");
  std::ofstream(folder_ / "window.toml") << std::ifstream(folder_ / "live.toml").rdbuf()
                                         << "[ct]\npath = \"" << file("ct.mha") << "\"\n";
  ASSERT_EQ(run(file("window.toml") + " --shots " + file("shots")), 0) << log();
  const nlohmann::json json = report();
  for (const auto& control : json["controls"]) {
    if (control["name"] != "record") continue;
    EXPECT_FALSE(control["clipped"].get<bool>()) << "Stop recording";
  }
  const nlohmann::json recordings = json["recordings"];
  ASSERT_EQ(recordings.size(), 2U);
  EXPECT_NE(recordings[0]["path"], recordings[1]["path"]);
  for (const auto& recording : recordings) {
    EXPECT_GT(recording["written"].get<int>(), 5);
    const std::string path = recording["path"].get<std::string>();
    EXPECT_EQ(sonde("replay " + path + " --ct " + file("ct.mha") + " --out " + file("replay") +
                    " --frames 1 --no-survey --width 160 --height 120"),
              0)
        << log();
  }
}

TEST_F(LiveWindowTest, ButtonsOfADeviceFreezeCaptureAndMark) {
  script(
      "wait frozen yes 60\nwait marks 2 60\nexpect frozen yes\nwait frozen no 60\npause 1\nquit\n");
  std::ofstream(folder_ / "window.toml")
      << std::ifstream(folder_ / "live.toml").rdbuf()
      << "buttons = [{name = \"left\", action = \"mark\", pressed_at_s = [2.5, 3.0]},\n"
         "{name = \"middle\", action = \"capture\", pressed_at_s = [3.2]},\n"
         "{name = \"right\", action = \"freeze\", pressed_at_s = [2.0, 8.0]}]\n[ct]\npath = \""
      << file("ct.mha") << "\"\n";
  ASSERT_EQ(run(file("window.toml") + " --shots " + file("shots")), 0) << log();
  const nlohmann::json buttons = report()["buttons"];
  ASSERT_EQ(buttons.size(), 5U) << buttons;
  EXPECT_EQ(buttons[0]["button"], "right");
  EXPECT_EQ(buttons[1]["action"], "mark");
  std::size_t snapshots = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "shots")) {
    if (entry.path().filename().string().starts_with("sonde-")) ++snapshots;
  }
  EXPECT_EQ(snapshots, 1U);
}

TEST_F(WindowProgramTest, ShowsAPhantomByTheOptionsOfPredicates) {
  script(
      "wait view.axial shown 60\nexpect histogram.count 2\nexpect histogram.bone-surface 0.600\n"
      "wait scene full 60\nshot phantom\nquit\n");
  const std::string set = (folder_ / "set.json").string();
  std::ofstream(set) << R"({"sonde_predicates": 1, "name": "two", "predicates": [
    {"name": "bone surface", "importance": 0.5, "where": {"intensity": {"low": 0.5}}},
    {"name": "rest", "importance": 0.5, "where": {"intensity": {"high": 0.5}}}]})";
  EXPECT_EQ(run("--phantom shoulder --phantom-side 32 --predicates " + set +
                " --importance 'bone surface=0.6' --shots " + folder_.path().string()),
            0)
      << log();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "phantom.png"));
  script("quit\n");
  EXPECT_EQ(run("--simulated --phantom neck"), 2);
  EXPECT_THAT(log(), HasSubstr("--phantom"));
  EXPECT_EQ(run("--importance vessel=0.5"), 2);
  EXPECT_THAT(log(), HasSubstr("--us-volume or --phantom"));
}

TEST_F(WindowProgramTest, ASetOfTooManyPredicatesIsNamedAndTheWindowStays) {
  std::ofstream set(folder_ / "set.json");
  set << R"({"sonde_predicates": 1, "name": "many", "predicates": [)";
  for (int i = 0; i < 64; ++i) {
    set << (i > 0 ? "," : "") << R"({"name": "p)" << i << R"(", "where": {"intensity": {}}})";
  }
  set << "]}";
  set.close();
  script("wait session failed 60\nexpect predicates none\nexpect histogram.count 0\nquit\n");
  EXPECT_EQ(run("--phantom neck --phantom-side 32 --predicates " + (folder_ / "set.json").string()),
            0)
      << log();
}

TEST_F(WindowProgramTest, ALiveWindowWritesNoImages) {
  std::ofstream(folder_ / "live.toml")
      << "[source]\nkind = \"live\"\n[[devices]]\nid = \"bench\"\nkind = \"simulated\"\n";
  const std::string images = (folder_ / "images").string();
  const std::string command = SONDE_PROGRAM " live --session " + (folder_ / "live.toml").string() +
                              " --ct ct.mha --window --out " + images + " >" +
                              (folder_ / "log").string() + " 2>&1";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2);
  EXPECT_THAT(log(), HasSubstr("--window of live devices excludes --out " + images));
  EXPECT_FALSE(std::filesystem::exists(images));
}

TEST_F(WindowProgramTest, RecordsOnlyLiveDevices) {
  std::ofstream(folder_ / "session.toml") << "[source]\nkind = \"simulated\"\n";
  script("quit\n");
  EXPECT_EQ(run((folder_ / "session.toml").string() + " --record " + (folder_ / "r.mcap").string()),
            2);
  EXPECT_THAT(log(), HasSubstr("--record: expected a session of live devices"));
}

TEST_F(WindowProgramTest, WithoutADisplayThereIsAClearError) {
  const std::string command = "env -u DISPLAY -u WAYLAND_DISPLAY -u QT_QPA_PLATFORM " SONDE_PROGRAM
                              " window >" +
                              (folder_ / "log").string() + " 2>&1";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 4);
  EXPECT_THAT(log(), HasSubstr("window: expected a display, found DISPLAY not set"));
}

}  // namespace
}  // namespace nav::app
