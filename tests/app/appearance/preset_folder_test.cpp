// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/appearance/preset_folder.hpp"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>

#include "app/appearance/appearance.hpp"
#include "render/engine.hpp"
#include "sim/anatomy/abdomen_phantom.hpp"
#include "sim/ct_scanner.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

const std::filesystem::path kFolder = SONDE_SOURCE_DIR "/app/appearance/presets";

std::vector<std::string> file_presets() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    names.push_back(entry.path().stem().string());
  }
  return names;
}

TEST(PresetFolderTest, TheProgramFindsItsPresets) {
  const auto names = all_preset_names();
  for (const std::string& name : file_presets()) {
    EXPECT_EQ(std::ranges::count(names, name), 1) << name;
  }
  EXPECT_EQ(names.front(), kContextualPreset);
  EXPECT_GE(file_presets().size(), 6U);
}

TEST(PresetFolderTest, EachFileIsReadAndWrittenWithoutAChange) {
  test::TemporaryFolder folder;
  for (const std::string& name : file_presets()) {
    const auto preset = read_preset(name, kFolder);
    ASSERT_TRUE(test::has_value(preset)) << name;
    EXPECT_EQ(preset->transfer.name(), name);
    ASSERT_TRUE(write_appearance_file(folder / (name + ".json"), *preset).has_value());
    const auto again = read_preset(name, folder / ".");
    ASSERT_TRUE(test::has_value(again)) << name;
    EXPECT_TRUE(render::same_classification(again->transfer, preset->transfer)) << name;
    EXPECT_EQ(again->fit_vessels, preset->fit_vessels) << name;
    EXPECT_EQ(to_json_text(*again), to_json_text(*preset)) << name;
  }
}

TEST(PresetFolderTest, AMissingFolderIsNamedAndBuiltInPresetsStay) {
  const std::filesystem::path nowhere = "/nowhere/appearances";
  EXPECT_TRUE(test::rejects(read_preset("ct-contextual", nowhere), ErrorCode::kNotFound,
                            {"/nowhere/appearances", "found none", "ct-contextual"}));
  const auto names = all_preset_names(nowhere);
  EXPECT_EQ(std::ranges::count(names, "ct-bone"), 1);
  EXPECT_EQ(std::ranges::count(names, "ct-contextual"), 0);
}

TEST(PresetFolderTest, ABrokenFileIsNamedAndTheOthersWork) {
  test::TemporaryFolder folder;
  std::filesystem::copy_file(kFolder / "ct-native.json", folder / "ct-native.json");
  std::ofstream(folder / "mine.json") << "{\"sonde_look\": 1, \"components\": [";
  EXPECT_TRUE(
      test::rejects(read_preset("mine", folder / "."), ErrorCode::kMalformedData, {"mine.json"}));
  EXPECT_TRUE(test::has_value(read_preset("ct-native", folder / ".")));
  EXPECT_TRUE(test::rejects(read_preset("other", folder / "."), ErrorCode::kNotFound,
                            {"other.json", "ct-native", "mine"}));
}

TEST(PresetFolderTest, VesselsAreFittedOnlyWhereTheyAreNamed) {
  test::TemporaryFolder folder;
  const auto file = folder / "none.json";
  std::ofstream(file) << R"({"sonde_look": 1, "fit_vessels": true, "components": [{"name": "a",
      "nodes": [{"value": 0, "opacity_per_mm": 0}, {"value": 9, "opacity_per_mm": 0.1}]}]})";
  EXPECT_TRUE(test::rejects(read_appearance_file(file), ErrorCode::kMalformedData,
                            {"fit_vessels", "vessels"}));
}

TEST(PresetFolderTest, WithoutItsFolderTheDefaultIsBuiltInAndSaysSo) {
  const char* const before = std::getenv("SONDE_APPEARANCES");
  const std::string kept = before == nullptr ? "" : before;
  setenv("SONDE_APPEARANCES", "/nowhere/appearances", 1);
  const auto ct = *Volume::create(VoxelGrid{{2, 2, 2}}, std::vector<std::int16_t>(8, -1000), "ct");
  const auto appearance = resolve_appearance({}, ct);
  ASSERT_TRUE(test::has_value(appearance));
  EXPECT_EQ(appearance->transfer.name(), "ct-soft-tissue");
  CollectingDiagnostics said;
  warn_of_missing_presets({}, ct, said);
  ASSERT_EQ(said.entries().size(), 1U);
  EXPECT_NE(said.entries()[0].message.find("/nowhere/appearances"), std::string::npos);
  SessionConfig::Appearance named;
  named.preset = "ct-bone";
  CollectingDiagnostics quiet;
  warn_of_missing_presets(named, ct, quiet);
  EXPECT_TRUE(quiet.entries().empty());
  named.preset = "ct-native";
  EXPECT_FALSE(resolve_appearance(named, ct).has_value()) << "what is asked for is not replaced";
  if (before == nullptr) {
    unsetenv("SONDE_APPEARANCES");
  } else {
    setenv("SONDE_APPEARANCES", kept.c_str(), 1);
  }
}

/// The contextual appearance of the simulated patient, with a plane in the liver.
class ContextualPresetTest : public ::testing::Test {
 protected:
  static constexpr int kSide = 160;

  /// A view from the front; with: the plane is drawn.
  static Image2d<Rgba8> view(sim::Contrast contrast, bool with_plane, bool with_cutaway) {
    const sim::AbdomenPhantom phantom({1, contrast});
    sim::CtOptions options;
    options.spacing_mm = {2, 2, 2};
    const auto ct = std::make_shared<const Volume>(*sim::scan_ct(phantom, options));
    const auto appearance = resolve_appearance({}, *ct);
    EXPECT_TRUE(test::has_value(appearance));
    render::Scene scene{.ct = ct, .transfer = appearance->transfer, .camera = render::Camera{}};
    if (appearance->drawn) {
      scene.ct = appearance->drawn->ct;
      scene.transfer = appearance->drawn->transfer;
    }
    scene.shading = appearance->shading;
    if (with_cutaway) scene.cutaway = appearance->cutaway;
    scene.width = scene.height = kSide;
    // In the liver, beside the great vessels.
    Eigen::Vector3d at(15, 0, 0);
    const auto targets = phantom.targets();
    for (const auto& target : targets) at += target.mm / static_cast<double>(targets.size());
    scene.camera = {{at + Eigen::Vector3d(0, -500, 0)}, {at}, {{0, 0, 1}}};
    scene.camera.vertical_fov_rad = 0.5;
    if (with_plane) {
      // A white image of 60 mm by 60 mm across the line of sight.
      UltrasoundImage frame;
      frame.grid = PixelGrid::centred(61, 1, 1);
      frame.pixels = {61, 61, std::vector<std::uint8_t>(61 * 61, 255)};
      Eigen::Matrix3d axes;
      axes << Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY();
      scene.plane =
          render::UltrasoundPlane{std::move(frame),
                                  {Eigen::Quaterniond(axes), at + Eigen::Vector3d(0, 0, 30)},
                                  1.0,
                                  {SafetyState::kValid, ""}};
    }
    const auto drawn = render::make_cpu_engine()->render(scene);
    EXPECT_TRUE(test::has_value(drawn));
    return render::to_8bit(drawn->pixels);
  }
  template <class Is>
  static double share(const Image2d<Rgba8>& image, const Is& is) {
    return static_cast<double>(std::ranges::count_if(image.pixels(), is)) /
           static_cast<double>(image.pixels().size());
  }
};

bool is_body(const Rgba8& p) { return std::max({p.r, p.g, p.b}) > 60; }
/// True for a pixel as grey and bright as the image of the plane.
bool is_plane(const Rgba8& p) {
  return p.r > 200 && std::abs(p.r - p.g) < 25 && std::abs(p.r - p.b) < 25;
}
bool is_vessel(const Rgba8& p) { return p.b > p.r + 40 && p.b > p.g + 20; }

TEST_F(ContextualPresetTest, ShowsTheBodyThePlaneAndTheVessels) {
  const auto whole = view(sim::Contrast::kPortal, false, false);
  const auto with = view(sim::Contrast::kPortal, true, true);
  EXPECT_GT(share(whole, is_body), 0.5) << "the body is not black";
  EXPECT_GT(share(with, is_body), 0.5) << "and it stays around the cutaway";
  // The plane covers 60 of 255 mm in both directions: 5.5 % of the view. Vessels hide some of it.
  EXPECT_GT(share(with, is_plane), 0.025) << "the plane is seen through the cutaway";
  EXPECT_LT(share(whole, is_plane), 0.005);
  EXPECT_GT(share(with, is_vessel), 0.002) << "vessels stay before the plane";
  EXPECT_LT(share(whole, is_vessel), 0.002) << "nothing of them shows through the skin";
}

TEST_F(ContextualPresetTest, MrIsDrawnByItsOwnPercentiles) {
  EXPECT_GT(share(view(sim::Contrast::kMr, true, true), is_body), 0.5);
  EXPECT_GT(share(view(sim::Contrast::kMr, true, true), is_plane), 0.03) << "fat is cut away";
  // Gain and offset of the scanner do not matter.
  const sim::AbdomenPhantom phantom({1, sim::Contrast::kMr});
  sim::CtOptions options;
  options.spacing_mm = {4, 4, 4};
  const auto one = *sim::scan_ct(phantom, options);
  std::vector<std::int16_t> values(one.values().begin(), one.values().end());
  for (auto& v : values) v = static_cast<std::int16_t>(3 * v + 500);
  const auto other = *Volume::create(one.grid(), values, "three times as bright");
  for (const char* preset : {"contextual", "mr-fat-suppressed", "mr-default"}) {
    SessionConfig::Appearance said;
    said.preset = preset;
    const auto a = resolve_appearance(said, one);
    const auto b = resolve_appearance(said, other);
    ASSERT_TRUE(test::has_value(a) && test::has_value(b));
    for (double v = 0; v <= 900; v += 50) {
      const auto at_a = a->transfer.at(v);
      const auto at_b = b->transfer.at(3 * v + 500);
      EXPECT_NEAR(at_a.tau_per_mm, at_b.tau_per_mm, 2e-3) << preset << " at " << v;
    }
  }
}

}  // namespace
}  // namespace nav::app
