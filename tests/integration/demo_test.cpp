// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the demo from the simulated tracker to the rendered image.
#include "app/verbs/demo.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "app/report.hpp"
#include "io/image_output.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

/// The demo promises this error at the target for a start error of 10 mm and 8 degrees.
constexpr double kPromisedErrorMm = 2.0;
/// The pose of the needle is measured with noise and displayed with the registration.
constexpr double kFinalTipMm = 3.0;

DemoOptions small_demo(const std::filesystem::path& out) {
  DemoOptions options;
  options.output.folder = out;
  options.output.width = 160;
  options.output.height = 120;
  options.output.frames = 4;
  options.output.threads = 1;
  options.output.step_voxels = 1;
  return options;
}

io::Json report_of(const std::filesystem::path& out) {
  std::ifstream file(out / "report.json");
  return io::Json::parse(file, nullptr, false);
}

TEST(DemoTest, RegistersGuidesAndCountsEveryImage) {
  const test::TemporaryFolder folder;
  Console console(false);
  ASSERT_TRUE(test::has_value(run_demo(small_demo(folder / "one"), console)));
  const io::Json report = report_of(folder / "one");
  EXPECT_NEAR(report["start_translation_mm"].get<double>(), 10, 0);
  EXPECT_GT(report["start_error_mm"].get<double>(), 5);
  EXPECT_TRUE(report["registration"]["accepted"]);
  EXPECT_LT(report["target_error_mm"].get<double>(), kPromisedErrorMm);
  EXPECT_LT(report["final_tip_to_target_mm"].get<double>(), kFinalTipMm);
  EXPECT_TRUE(report["ledger"]["balanced"]);
  EXPECT_GT(report["ledger"]["superseded"], 0) << "images come faster than refreshes";
  for (const auto& file : report["frames"]) {
    EXPECT_TRUE(std::filesystem::exists(folder / "one" / file.get<std::string>())) << file;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "one" / "report.html"));
  EXPECT_GT(std::filesystem::file_size(folder / "one" / "demo.webp"), 1000u);

  // Equal input gives equal bytes with one and two threads.
  DemoOptions two = small_demo(folder / "two");
  two.output.threads = 2;
  ASSERT_TRUE(test::has_value(run_demo(two, console)));
  const io::Json again = report_of(folder / "two");
  EXPECT_EQ(again["pose_log_sha256"], report["pose_log_sha256"]);
  EXPECT_EQ(again["image_sha256"], report["image_sha256"]);
  EXPECT_EQ(again["target_error_mm"], report["target_error_mm"]);
}

TEST(DemoTest, FewImagesShowAnApproachThatAHandCanMake) {
  for (const int images : {1, 3}) {
    const test::TemporaryFolder folder;
    Console console(false);
    DemoOptions few = small_demo(folder / "out");
    few.output.frames = images;
    ASSERT_TRUE(test::has_value(run_demo(few, console)));
    const io::Json report = report_of(folder / "out");
    int shown = 0;
    for (const auto& file : report["frames"]) {
      shown += file.get<std::string>().starts_with("approach_") ? 1 : 0;
    }
    EXPECT_EQ(shown, images);
    EXPECT_LT(report["final_tip_to_target_mm"].get<double>(), kFinalTipMm);
    EXPECT_FALSE(report["rejected_poses"].contains("Needle.too_fast")) << report["rejected_poses"];
    EXPECT_FALSE(report["rejected_poses"].contains("Needle.off_path")) << report["rejected_poses"];
    EXPECT_TRUE(report["ledger"]["balanced"]);
  }
}

TEST(DemoTest, ARejectedRegistrationNeverShowsTheUltrasoundPlane) {
  const test::TemporaryFolder folder;
  Console console(false);
  DemoOptions hopeless = small_demo(folder / "out");
  hopeless.start_error_mm = 80;
  hopeless.start_error_deg = 70;
  const auto outcome = run_demo(hopeless, console);
  EXPECT_TRUE(test::rejects(outcome, ErrorCode::kRefused, {"refused"}));
  const io::Json report = report_of(folder / "out");
  EXPECT_FALSE(report["registration"]["accepted"]);
  EXPECT_FALSE(report["registration"]["reasons"].empty());
  EXPECT_TRUE(report["final_tip_to_target_mm"].is_null()) << "no number without a registration";
  for (const auto& file : report["frames"]) {
    EXPECT_FALSE(file.get<std::string>().starts_with("approach_")) << file;
  }
  EXPECT_TRUE(report["ledger"]["balanced"]);
}

}  // namespace
}  // namespace nav::app
