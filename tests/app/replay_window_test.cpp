// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Runs replays of the built program in a real X11 window.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>
#include <sys/wait.h>

#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

class ReplayWindowTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::getenv("DISPLAY") == nullptr) GTEST_SKIP() << "no X display (run under xvfb-run)";
    ASSERT_EQ(run("simulate --out " + recording() + " --ct " + ct() +
                  " --ct-spacing-mm 5 --duration-s 1 --frame-rate-hz 10 --columns 64 --rows 64"),
              0);
  }
  [[nodiscard]] std::string recording() const { return (folder_ / "sweep.mha").string(); }
  [[nodiscard]] std::string ct() const { return (folder_ / "ct.mha").string(); }
  [[nodiscard]] int run(const std::string& arguments) const { return shell(program(arguments)); }
  /// Sends Ctrl-C when the program has printed a text, or after two minutes at the latest.
  [[nodiscard]] int run_until(const std::string& words, const std::string& arguments) const {
    return shell(program(arguments) + " & sonde=$!; for i in $(seq 1200); do grep -q '" + words +
                 "' " + log() + " && break; sleep 0.1; done; kill -INT $sonde; wait $sonde");
  }
  test::TemporaryFolder folder_;

 private:
  [[nodiscard]] std::string log() const { return (folder_ / "log").string(); }
  [[nodiscard]] std::string program(const std::string& arguments) const {
    return SONDE_PROGRAM " " + arguments + " >" + log() + " 2>&1";
  }
  [[nodiscard]] static int shell(const std::string& command) {
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
};

TEST_F(ReplayWindowTest, ShowsTheRecordingByAnyEngineAndWritesNothingButTheReport) {
  for (const std::string engine : {"cpu", "gl"}) {
    const auto report = folder_ / (engine + ".json");
    EXPECT_EQ(
        run_until("the recording has ended",
                  "replay " + recording() + " --ct " + ct() + " --engine " + engine +
                      " --window --width 160 --height 120 --step 4 --json " + report.string()),
        0);
    std::ifstream file(report);
    ASSERT_TRUE(file.good());
    const auto json = nlohmann::json::parse(file);
    EXPECT_EQ(json["engine"], engine);
    EXPECT_GE(json["views_cast"].get<int>(), 1);
    EXPECT_TRUE(json["frames"].empty());
    EXPECT_TRUE(json["image_sha256"].is_null());
    EXPECT_TRUE(json["ledger"]["balanced"].get<bool>());
    EXPECT_GE(json["ledger"]["shown"].get<int>(), 1);
  }
  int images = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path())) {
    images += entry.path().extension() == ".png" ? 1 : 0;
  }
  EXPECT_EQ(images, 0);
}

}  // namespace
}  // namespace nav::app
