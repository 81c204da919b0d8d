// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>

#include "app/appearance/appearance.hpp"
#include "app/appearance/appearance_file.hpp"
#include "tests/render/scene_support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

constexpr double kRadOfDeg = M_PI / 180;

class ResolveAppearanceTest : public ::testing::Test {
 protected:
  static Volume voxel() {
    return *Volume::create(VoxelGrid{{1, 1, 1}}, std::vector<std::int16_t>(1), "voxel");
  }
  /// Appearance file with every part; sessions override parts of it.
  std::filesystem::path appearance_file() {
    render::Shading shading;
    shading.style = render::ShadingStyle::kGooch;
    shading.emphasis = 0.25;
    render::Cutaway cutaway;
    cutaway.theta1_rad = 10 * kRadOfDeg;
    cutaway.theta2_rad = 20 * kRadOfDeg;
    cutaway.around_needle = true;
    const auto path = folder_ / "look.json";
    const AppearanceFile appearance{
        *render::TransferFunction::create("mine",
                                          {{0, {1, 0, 0}, 0.1, 0.3}, {9, {1, 0, 0}, 0.1, 0.3}}),
        shading,
        cutaway,
        {}};
    EXPECT_TRUE(write_appearance_file(path, appearance).has_value());
    return path;
  }
  test::TemporaryFolder folder_;
};

TEST_F(ResolveAppearanceTest, CutsAroundThePlaneByDefault) {
  const auto appearance = resolve_appearance({}, voxel());
  ASSERT_TRUE(test::has_value(appearance));
  EXPECT_EQ(appearance->transfer.name(), "mr-contextual") << "a voxel of 0 is not in HU";
  ASSERT_TRUE(appearance->cutaway.has_value());
  EXPECT_TRUE(appearance->cutaway->around_plane);
  EXPECT_FALSE(appearance->cutaway->around_needle);
  EXPECT_EQ(appearance->projection, render::Projection::kComposite);
  SessionConfig::Appearance off;
  off.cutaway.enabled = false;
  EXPECT_FALSE(resolve_appearance(off, voxel())->cutaway.has_value());
}

TEST_F(ResolveAppearanceTest, WarnsOfComponentsBetweenWholeNumbers) {
  const auto warnings = [](std::vector<render::TransferComponent> components) {
    CollectingDiagnostics diagnostics;
    warn_of_lost_components(*render::TransferFunction::blend("t", std::move(components)),
                            diagnostics);
    std::vector<std::string> said;
    for (const auto& entry : diagnostics.entries()) said.push_back(entry.message);
    return said;
  };
  const render::TransferComponent lost{
      "mask", {{0.3, {1, 1, 1}, 0, 1}, {0.5, {1, 1, 1}, 0.8, 1}, {0.7, {1, 1, 1}, 0, 1}}, {}};
  render::TransferComponent kept = lost;
  for (auto& node : kept.nodes) node.hu *= 1000;
  const auto said = warnings({kept, lost});
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("component mask"), std::string::npos) << said[0];
  EXPECT_NE(said[0].find("0.8 at 0.5, of which 0 is drawn"), std::string::npos) << said[0];
  // A step between neighbouring values loses nothing.
  EXPECT_TRUE(
      warnings({{"step", {{99.999, {1, 1, 1}, 0, 1}, {100, {1, 1, 1}, 0.8, 1}}, {}}}).empty());
  for (const char* name : {"ct-bone", "ct-liver", "cta-vessels", "mr-default"}) {
    CollectingDiagnostics diagnostics;
    warn_of_lost_components(*render::preset_transfer_function(name), diagnostics);
    EXPECT_TRUE(diagnostics.entries().empty()) << name;
  }
}

TEST_F(ResolveAppearanceTest, KnowsWhichAppearancesMayBeForOtherUnitsThanHounsfield) {
  SessionConfig::Appearance appearance;
  EXPECT_TRUE(draws_hounsfield_units(appearance));
  appearance.preset = "ct-bone";
  EXPECT_TRUE(draws_hounsfield_units(appearance));
  appearance.preset = "mr-default";
  EXPECT_FALSE(draws_hounsfield_units(appearance));
  appearance.preset = "ct-bone";
  appearance.file = appearance_file();
  EXPECT_FALSE(draws_hounsfield_units(appearance));
}

TEST_F(ResolveAppearanceTest, TheSessionOverridesTheFile) {
  SessionConfig::Appearance said;
  said.file = appearance_file();
  auto appearance = resolve_appearance(said, voxel());
  ASSERT_TRUE(test::has_value(appearance));
  EXPECT_EQ(appearance->transfer.name(), "mine");
  EXPECT_EQ(appearance->shading.style, render::ShadingStyle::kGooch);
  EXPECT_EQ(appearance->shading.emphasis, 0.25);
  EXPECT_NEAR(appearance->cutaway->theta2_rad, 20 * kRadOfDeg, 1e-12);
  EXPECT_TRUE(appearance->cutaway->around_needle);
  said.style = "phong";
  said.emphasis = 0.75;
  said.shading = false;
  said.cutaway.theta2_deg = 60;
  said.cutaway.overlay_mm = std::numeric_limits<double>::infinity();
  said.cutaway.around_needle = false;
  said.importance = {{-100, 100, 1.0}};
  said.projection = "maximum";
  appearance = resolve_appearance(said, voxel());
  ASSERT_TRUE(test::has_value(appearance));
  EXPECT_EQ(appearance->shading.style, render::ShadingStyle::kPhong);
  EXPECT_EQ(appearance->shading.emphasis, 0.75);
  EXPECT_FALSE(appearance->shading.enabled);
  EXPECT_NEAR(appearance->cutaway->theta1_rad, 10 * kRadOfDeg, 1e-12) << "the file's";
  EXPECT_NEAR(appearance->cutaway->theta2_rad, 60 * kRadOfDeg, 1e-12);
  EXPECT_TRUE(std::isinf(appearance->cutaway->overlay_mm));
  EXPECT_FALSE(appearance->cutaway->around_needle);
  EXPECT_EQ(appearance->transfer.at(5).importance, 1);
  EXPECT_EQ(appearance->projection, render::Projection::kMaximum);
}

TEST_F(ResolveAppearanceTest, SmoothingTableAndThresholdsAreKeptInAFileAndOverridden) {
  SessionConfig::Appearance said;
  said.preset = "ct-bone";
  said.smoothing_mm = 1.5;
  said.cutaway.constant = Eigen::Vector2d(0.25, 0.75);
  const auto appearance = resolve_appearance(said, voxel());
  ASSERT_TRUE(test::has_value(appearance));
  EXPECT_EQ(appearance->smoothing_mm, 1.5);
  ASSERT_TRUE(appearance->drawn);
  EXPECT_TRUE(appearance->drawn->gradient_source);
  EXPECT_FALSE(appearance->remove_table) << "a built-in preset";
  SessionConfig::Appearance saved;
  saved.file = folder_ / "smooth.json";
  ASSERT_TRUE(test::has_value(save_appearance(saved.file, *appearance)));
  auto again = resolve_appearance(saved, voxel());
  ASSERT_TRUE(test::has_value(again));
  EXPECT_EQ(again->smoothing_mm, 1.5);
  ASSERT_TRUE(again->cutaway && again->cutaway->constant);
  EXPECT_EQ(again->cutaway->constant->lower, 0.25);
  EXPECT_EQ(again->cutaway->constant->upper, 0.75);
  saved.smoothing_mm = 0;
  again = resolve_appearance(saved, voxel());
  EXPECT_FALSE(again->drawn) << "nothing is made where nothing is smoothed";
  said.smoothing_mm.reset();
  EXPECT_FALSE(resolve_appearance(said, voxel())->drawn);
  said.cutaway.constant = Eigen::Vector2d(0.8, 0.2);
  EXPECT_TRUE(test::rejects(resolve_appearance(said, voxel()), ErrorCode::kUsage,
                            {"constant_thresholds", "in order"}));
}

TEST_F(ResolveAppearanceTest, ASavedAppearanceKeepsItsVolumeAndFollowsOtherValueRanges) {
  const auto bright = [](int scale) {
    std::vector<std::int16_t> values;
    for (int i = 0; i < 1000; ++i) values.push_back(static_cast<std::int16_t>(scale * (i % 100)));
    return *Volume::create(VoxelGrid{{10, 10, 10}}, std::move(values), "mr");
  };
  SessionConfig::Appearance said;
  said.preset = "mr-default";
  said.style = "gooch";
  said.emphasis = 0.25;
  said.importance = {{70, 90, 0.75}};
  said.cutaway.theta1_deg = 20;
  said.cutaway.around_targets = true;
  const auto appearance = resolve_appearance(said, bright(1));
  ASSERT_TRUE(test::has_value(appearance));
  ASSERT_TRUE(appearance->value_range);
  SessionConfig::Appearance saved;
  saved.file = folder_ / "saved.json";
  ASSERT_TRUE(test::has_value(save_appearance(saved.file, *appearance)));
  const auto same = resolve_appearance(saved, bright(1));
  const auto other = resolve_appearance(saved, bright(10));
  ASSERT_TRUE(test::has_value(same));
  ASSERT_TRUE(test::has_value(other));
  for (const double value : {10.0, 40.0, 70.0, 95.0}) {
    EXPECT_NEAR(same->transfer.at(value).tau_per_mm, appearance->transfer.at(value).tau_per_mm,
                1e-9);
    EXPECT_NEAR(same->transfer.at(value).importance, appearance->transfer.at(value).importance,
                1e-9);
    EXPECT_NEAR(other->transfer.at(10 * value).tau_per_mm,
                appearance->transfer.at(value).tau_per_mm, 1e-6);
  }
  EXPECT_NEAR(same->transfer.at(80).importance, 0.75, 1e-9) << "what was said over the preset";
  EXPECT_EQ(same->shading.style, render::ShadingStyle::kGooch);
  EXPECT_EQ(same->shading.emphasis, 0.25);
  EXPECT_NEAR(same->cutaway->theta1_rad, 20 * kRadOfDeg, 1e-9);
  EXPECT_TRUE(same->cutaway->around_spheres);

  said.cutaway = {.enabled = false};
  said.preset = "ct-liver";
  said.importance.clear();
  const auto liver = resolve_appearance(said, bright(1));
  ASSERT_TRUE(test::has_value(save_appearance(saved.file, *liver)));
  EXPECT_FALSE(read_appearance_file(saved.file)->value_range) << "HU are absolute";
  EXPECT_FALSE(resolve_appearance(saved, bright(1))->cutaway);
  EXPECT_TRUE(test::rejects(save_appearance(folder_ / "no" / "such.json", *liver), ErrorCode::kIo,
                            {"such.json"}));
}

TEST_F(ResolveAppearanceTest, AScaledAppearanceIsShadedLikeTheOriginal) {
  constexpr double kByte = 1.0 / 255;
  // Soft edges, so that shading is in proportion to the gradient.
  const auto blob = [](int scale, int shift) {
    return test::make_volume(test::centred_grid({24, 24, 24}, {1, 1, 1}), [=](int i, int j, int k) {
      const double r = std::hypot(i - 11.5, j - 11.5, k - 11.5);
      return shift + scale * std::lround(100 * std::exp(-r * r / 60));
    });
  };
  const auto image = [](const std::shared_ptr<const StoredVolume>& ct,
                        const ResolvedAppearance& appearance) {
    auto scene = test::plain_scene(ct, appearance.transfer, test::frontal(100, 30, false));
    scene.shading = appearance.shading;
    return test::draw(*render::make_cpu_engine(), scene);
  };
  const auto original = blob(1, 0);
  const auto other = blob(2, 30);
  SessionConfig::Appearance preset;
  preset.preset = "mr-default";
  const auto appearance = *resolve_appearance(preset, Volume(*original));
  const auto drawn = image(original, appearance);
  SessionConfig::Appearance saved;
  saved.file = folder_ / "saved.json";
  ASSERT_TRUE(test::has_value(save_appearance(saved.file, appearance)));
  for (const auto& said : {preset, saved}) {
    const auto carried = *resolve_appearance(said, Volume(*other));
    EXPECT_NEAR(carried.shading.full_gradient_per_mm, 2 * appearance.shading.full_gradient_per_mm,
                1e-9);
    EXPECT_LT(test::max_difference(image(other, carried), drawn), kByte);
  }
  auto flat = appearance;
  flat.shading.enabled = false;
  EXPECT_GT(test::max_difference(image(original, flat), drawn), 20 * kByte) << "nothing is shaded";
}

TEST_F(ResolveAppearanceTest, RejectsContradictingValues) {
  SessionConfig::Appearance said;
  said.file = appearance_file();
  said.cutaway.theta1_deg = 45;
  EXPECT_TRUE(test::rejects(resolve_appearance(said, voxel()), ErrorCode::kUsage,
                            {"look.cutaway.theta1_deg", "at most theta2_deg, 20", "45"}));
  said = {};
  said.preset = "x-ray";
  EXPECT_TRUE(
      test::rejects(resolve_appearance(said, voxel()), ErrorCode::kUsage, {"x-ray", "ct-liver"}));
  said = {};
  said.file = folder_ / "nothing.vp";
  EXPECT_TRUE(
      test::rejects(resolve_appearance(said, voxel()), ErrorCode::kNotFound, {"nothing.vp"}));
  said = {};
  said.importance = {{0, 100, 2}};
  EXPECT_TRUE(
      test::rejects(resolve_appearance(said, voxel()), ErrorCode::kUsage, {"importance", "2"}));
}

TEST_F(ResolveAppearanceTest, RejectsCutawayValuesForAnAppearanceThatDoesNotCut) {
  SessionConfig::Appearance said;
  said.file = folder_ / "whole.json";
  std::ofstream(said.file) << R"({"sonde_look": 1, "name": "whole", "cutaway": null, "components": [
      {"name": "all", "nodes": [{"value": 0, "rgb": [1, 1, 1], "opacity_per_mm": 0},
                                 {"value": 9, "rgb": [1, 1, 1], "opacity_per_mm": 0.1}]}]})";
  const auto whole = resolve_appearance(said, voxel());
  ASSERT_TRUE(test::has_value(whole));
  EXPECT_FALSE(whole->cutaway);
  said.cutaway.theta1_deg = 20;
  EXPECT_TRUE(test::rejects(resolve_appearance(said, voxel()), ErrorCode::kUsage,
                            {"look.cutaway", "enabled = true"}));
  said.cutaway.enabled = false;
  EXPECT_FALSE(resolve_appearance(said, voxel())->cutaway);
  said.cutaway.enabled = true;
  EXPECT_NEAR(resolve_appearance(said, voxel())->cutaway->theta1_rad, 20 * kRadOfDeg, 1e-12);
}

TEST_F(ResolveAppearanceTest, ChecksEveryValueOfASession) {
  const auto refused = [](auto change, const std::string& key) {
    SessionConfig::Appearance appearance;
    change(appearance);
    return test::rejects(validate(appearance), ErrorCode::kUsage, {"look." + key});
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused([](auto& l) { l.style = "flat"; }, "style"));
  EXPECT_TRUE(refused([](auto& l) { l.emphasis = 1.5; }, "emphasis"));
  EXPECT_TRUE(refused([&](auto& l) { l.emphasis = nan; }, "emphasis"));
  EXPECT_TRUE(refused([](auto& l) { l.projection = "mip"; }, "projection"));
  EXPECT_TRUE(refused([](auto& l) { l.grey_width_hu = 0; }, "grey_width_hu"));
  EXPECT_TRUE(refused([](auto& l) { l.cutaway.theta1_deg = 0; }, "cutaway.theta1_deg"));
  EXPECT_TRUE(refused([](auto& l) { l.cutaway.theta2_deg = 90; }, "cutaway.theta2_deg"));
  EXPECT_TRUE(refused([](auto& l) { l.cutaway.overlay_mm = -1; }, "cutaway.overlay_mm"));
  EXPECT_TRUE(refused([&](auto& l) { l.cutaway.overlay_mm = nan; }, "cutaway.overlay_mm"));
  EXPECT_TRUE(refused(
      [](auto& l) {
        l.cutaway.theta1_deg = 40;
        l.cutaway.theta2_deg = 30;
      },
      "cutaway.theta1_deg"));
}

}  // namespace
}  // namespace nav::app
