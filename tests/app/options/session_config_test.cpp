// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_config.hpp"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

using Code = ErrorCode;

class SessionConfigTest : public ::testing::Test {
 protected:
  auto read(const std::string& text) {
    const auto path = folder_ / "session.toml";
    std::ofstream(path) << text;
    return read_session_config(path);
  }
  test::TemporaryFolder folder_;
};

TEST_F(SessionConfigTest, ReadsEverySectionAndResolvesPaths) {
  const auto config = read(R"(
[ct]
path = "scan"
[source]
kind = "recording"
recording = "sweep.igs.mha"
plus_config = "/abs/plus.xml"
temporal_offset_ms = 12
[placement]
ct_from_reference_mm = [1,0,0,5, 0,1,0,6, 0,0,1,7, 0,0,0,1]
[look]
transfer_function = "cta-vessels"
nodes = [{hu = 0, rgb = [1,0,0], opacity_per_mm = 0, importance = 0},
         {hu = 100, rgb = [1,1,1], opacity_per_mm = 0.5, importance = 1}]
[view]
azimuth_deg = -10.5
[output]
folder = "out"
engine = "reference"
width_px = 320
)");
  ASSERT_TRUE(test::has_value(config));
  EXPECT_EQ(config->ct.path, folder_ / "scan");
  EXPECT_EQ(config->source.plus_config, "/abs/plus.xml");
  EXPECT_EQ(config->source.temporal_offset_ms, 12);
  EXPECT_EQ((*config->placement.ct_from_reference)(1, 3), 6);
  EXPECT_EQ(config->appearance.nodes.at(1).opacity, 0.5);
  EXPECT_EQ(config->view.azimuth_deg, -10.5);
  EXPECT_EQ(config->output.width, 320);
}

TEST_F(SessionConfigTest, TheResolvedFormReadsBackToTheSame) {
  const auto first = read(
      "[ct]\npath = \"a\"\n[output]\nwidth_px = 123\n[look]\nnodes = "
      "[{hu=0,opacity_per_mm=0.0},{hu=1,opacity_per_mm=0.1}]\n");
  ASSERT_TRUE(test::has_value(first));
  const auto second = read(*to_toml(*first));
  ASSERT_TRUE(test::has_value(second));
  EXPECT_EQ(*to_toml(*first), *to_toml(*second));
  EXPECT_EQ(second->output.width, 123);
}

TEST_F(SessionConfigTest, ReadsThePlanAndTheKindOfView) {
  const std::string plan =
      "[plan]\nentry_mm = [1, -80, 5]\ntarget_mm = [1, 2, 3]\ntarget_radius_mm = 6\n";
  const auto config = read(plan + "margin_mm = 4.5\n[view]\northographic = true\n");
  ASSERT_TRUE(test::has_value(config));
  EXPECT_TRUE(config->view.orthographic);
  ASSERT_TRUE(config->plan);
  EXPECT_EQ(config->plan->entry_ct.mm.y(), -80);
  EXPECT_EQ(config->plan->target_ct.mm.z(), 3);
  EXPECT_EQ(config->plan->margin_mm, 4.5);
  const auto again = read(*to_toml(*config));
  ASSERT_TRUE(test::has_value(again));
  EXPECT_EQ(*to_toml(*again), *to_toml(*config));
  EXPECT_EQ(read(plan)->plan->margin_mm, 0);
  EXPECT_FALSE(read("")->plan);
  const auto refused = [&](const std::string& text, const std::string& key) {
    return test::rejects(read(text), Code::kMalformedData, {key});
  };
  EXPECT_TRUE(refused("[plan]\nentry_mm = [1, 2, 3]\ntarget_radius_mm = 6\n",
                      "plan.target_mm: expected 3 finite numbers, found nothing"));
  EXPECT_TRUE(refused("[plan]\nentry_mm = [1, 2, 3]\ntarget_mm = [1, 9, 3]\n",
                      "plan.target_radius_mm: expected a finite number, found nothing"));
  EXPECT_TRUE(refused("[plan]\nentry_mm = [1, nan, 3]\n", "plan.entry_mm"));
  EXPECT_TRUE(refused(plan + "margin_mm = -1\n", "plan.margin_mm"));
  EXPECT_TRUE(refused(plan + "[source]\nkind = \"simulated\"\n", "plan"));
  EXPECT_TRUE(refused("plan = 3\n", "plan"));
  EXPECT_TRUE(
      refused("[plan]\nentry_mm = [1, 2, 3]\ntarget_mm = [1, 2, 3]\n"
              "target_radius_mm = 6\n",
              "1 mm apart"));
}

TEST_F(SessionConfigTest, ReadsTheWindowOfFlatImagesAndKeepsItsAbsence) {
  const auto config = read("[view]\nwindow_level = -500\nwindow_width = 1500\n");
  ASSERT_TRUE(test::has_value(config));
  EXPECT_EQ(config->view.window_level, -500);
  EXPECT_EQ(config->view.window_width, 1500);
  const auto again = read(*to_toml(*config));
  ASSERT_TRUE(test::has_value(again));
  EXPECT_EQ(*to_toml(*again), *to_toml(*config));
  EXPECT_EQ(to_toml(*read(""))->find("window_"), std::string::npos);
  EXPECT_TRUE(test::rejects(read("[view]\nwindow_width = 0\n"), Code::kMalformedData,
                            {"view.window_width: expected 0.001 to 1000000 HU, found 0"}));
  EXPECT_TRUE(test::rejects(read("[view]\nwindow_level = 2e6\n"), Code::kMalformedData,
                            {"view.window_level"}));
}

TEST_F(SessionConfigTest, ReadsTheQualityAndRejectsContradictions) {
  const auto config = read("[quality]\nclassification = \"post-classified\"\njitter = true\n");
  ASSERT_TRUE(test::has_value(config));
  EXPECT_EQ(config->quality.classification, "post-classified");
  EXPECT_TRUE(config->quality.jitter);
  const auto again = read(*to_toml(*config));
  ASSERT_TRUE(test::has_value(again));
  EXPECT_EQ(*to_toml(*again), *to_toml(*config));
  EXPECT_TRUE(test::has_value(read("[quality]\nadaptive_error = 0.01\n"))) << "retired";
  const auto refused = [&](const std::string& text, const std::string& key) {
    return test::rejects(read(text), Code::kMalformedData, {key});
  };
  EXPECT_TRUE(refused("[quality]\nclassification = \"none\"\n", "quality.classification"));
  EXPECT_TRUE(refused("[quality]\njitter = true\n[output]\npixel_error = 0.1\n",
                      "output.pixel_error: expected 0 beside quality.jitter"));
  EXPECT_TRUE(refused("[quality]\nstep = 1\n", "quality.step"));
}

TEST_F(SessionConfigTest, ReadsTheAppearance) {
  const auto config = read(R"(
[look]
file = "liver.vp"
style = "gooch"
emphasis = 0.5
projection = "mean"
grey_level_hu = 40
importance = [{low_hu = 150, high_hu = 300, importance = 1}]
[look.cutaway]
enabled = true
theta1_deg = 20
theta2_deg = 45
overlay_mm = inf
around_needle = true
around_targets = false
)");
  ASSERT_TRUE(test::has_value(config));
  const auto& appearance = config->appearance;
  EXPECT_EQ(appearance.file, folder_ / "liver.vp");
  EXPECT_EQ(appearance.style, "gooch");
  EXPECT_EQ(appearance.emphasis, 0.5);
  EXPECT_EQ(appearance.importance.at(0).high_hu, 300);
  EXPECT_EQ(appearance.cutaway.enabled, true);
  EXPECT_EQ(appearance.cutaway.theta2_deg, 45);
  EXPECT_TRUE(std::isinf(*appearance.cutaway.overlay_mm));
  EXPECT_FALSE(appearance.cutaway.around_plane.has_value()) << "not said";
  EXPECT_EQ(appearance.cutaway.around_targets, false);
  const auto again = read(*to_toml(*config));
  ASSERT_TRUE(test::has_value(again));
  EXPECT_EQ(*to_toml(*again), *to_toml(*config));
  EXPECT_TRUE(test::rejects(read("[look.cutaway]\ntheta_deg = 3\n"), Code::kMalformedData,
                            {"look.cutaway.theta_deg"}));
  EXPECT_TRUE(test::rejects(read("[look]\ncutaway = 3\n"), Code::kMalformedData,
                            {"look.cutaway", "a table"}));
  EXPECT_TRUE(test::rejects(read("[look.cutaway]\noverlay_mm = nan\n"), Code::kMalformedData,
                            {"look.cutaway.overlay_mm", "a number or inf"}));
  EXPECT_TRUE(test::rejects(read("[look.cutaway]\nenabled = 1\n"), Code::kMalformedData,
                            {"look.cutaway.enabled", "true or false"}));
}

TEST_F(SessionConfigTest, RejectsUnknownKeysAndSectionsByLine) {
  EXPECT_TRUE(test::rejects(read("[ct]\n\npth = \"a\"\n"), Code::kMalformedData,
                            {"session.toml:3", "ct.pth", "path"}));
  EXPECT_TRUE(test::rejects(read("[cutaway]\nangle_deg = 1\n"), Code::kMalformedData, {"cutaway"}));
  EXPECT_TRUE(test::rejects(read("ct = 3\n"), Code::kMalformedData, {"ct"}));
  EXPECT_TRUE(test::rejects(read("[view]\nfov = 3\n"), Code::kMalformedData, {"view.fov"}));
  EXPECT_TRUE(test::rejects(read("[look]\nnodes=[{hu=1,alpha=2}]\n"), Code::kMalformedData,
                            {"look.nodes.alpha"}));
}

TEST_F(SessionConfigTest, RejectsAnAppearanceWithMissingNumbersByLine) {
  EXPECT_TRUE(test::rejects(read("[look]\nnodes = [{rgb = [1,1,1]}]\n"), Code::kMalformedData,
                            {"session.toml:2", "look.nodes.hu", "found nothing"}));
  EXPECT_TRUE(test::rejects(read("[look]\nnodes = [{hu = 1}]\n"), Code::kMalformedData,
                            {"session.toml:2", "look.nodes.opacity_per_mm", "found nothing"}));
  EXPECT_TRUE(test::rejects(read("[look]\nimportance = [{}]\n"), Code::kMalformedData,
                            {"session.toml:2", "look.importance.importance", "found nothing"}));
  EXPECT_TRUE(test::has_value(read("[look]\nimportance = [{importance = 1}]\n")));
}

TEST_F(SessionConfigTest, RejectsWrongTypesAndRanges) {
  EXPECT_TRUE(test::rejects(read("[output]\nwidth_px = \"wide\"\n"), Code::kMalformedData,
                            {":2", "output.width_px", "whole number", "wide"}));
  EXPECT_TRUE(test::rejects(read("[output]\nwidth_px = -3\n"), Code::kMalformedData, {"-3"}));
  EXPECT_TRUE(test::rejects(read("[view]\nfov_deg = nan\n"), Code::kMalformedData,
                            {"view.fov_deg", "finite", "nan"}));
  EXPECT_TRUE(test::rejects(read("[output]\nengine = \"vulkan\"\n"), Code::kMalformedData,
                            {"output.engine", "vulkan"}));
  EXPECT_TRUE(
      test::rejects(read("[output]\nstep_voxels = 0\n"), Code::kMalformedData, {"step_voxels"}));
  EXPECT_TRUE(
      test::rejects(read("[output]\npixel_error = 1.5\n"), Code::kMalformedData, {"pixel_error"}));
  EXPECT_TRUE(test::rejects(read("[placement]\nct_from_reference_mm = [1,2,3]\n"),
                            Code::kMalformedData, {"16 finite numbers"}));
  EXPECT_TRUE(test::rejects(read("[source]\nkind = \"telepathy\"\n"), Code::kMalformedData,
                            {"source.kind", "telepathy"}));
  EXPECT_TRUE(test::rejects(read("[source]\nkind = \"device\"\n"), Code::kMalformedData,
                            {"source.kind", "device"}));
}

TEST_F(SessionConfigTest, MessagesHaveOneLineOfUsualLength) {
  const auto message = [&](const std::string& text) {
    const auto config = read(text);
    return config ? std::string() : config.error().message;
  };
  const std::string lines = message("[source]\nkind = \"\"\"a\nb\"\"\"\n");
  EXPECT_NE(lines.find("a\\nb"), std::string::npos) << lines;
  EXPECT_EQ(lines.find('\n'), std::string::npos);
  EXPECT_LT(message("[source]\nkind = \"" + std::string(100000, 'x') + "\"\n").size(), 1000U);
}

TEST_F(SessionConfigTest, RejectsTextThatIsNotToml) {
  EXPECT_TRUE(test::rejects(read("[ct\npath"), Code::kMalformedData, {"session.toml:1"}));
  EXPECT_TRUE(
      test::rejects(read_session_config(folder_ / "none.toml"), Code::kNotFound, {"none.toml"}));
  EXPECT_TRUE(test::rejects(read_session_config(folder_.path()), Code::kNotFound, {"not a file"}));
}

}  // namespace
}  // namespace nav::app
