// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/appearance/appearance_file.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <unistd.h>

#include "tests/support/matchers.hpp"

namespace nav::app {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDeg = M_PI / 180;

/// Example from Slicer's developer guide.
const std::string kVp =
    "1\n1\n0.9\n0.1\n0.2\n10\n"
    "14 -3024 0 -86.9767 0 45.3791 0.169643 139.919 0.589286 347.907 0.607143 1224.16 0.607143 "
    "3071 0.616071\n"
    "4 0 1 255 1\n"
    "28 -3024 0 0 0 -86.9767 0 0.25098 1 45.3791 1 0 0 139.919 1 0.894893 0.894893 347.907 1 1 "
    "0.25098 1224.16 1 1 1 3071 0.827451 0.658824 1\n";

const std::string kVpJson = R"({
  "@schema": "https://raw.githubusercontent.com/slicer/slicer/main/Modules/Loadable/VolumeRendering/Resources/Schema/volume-property-schema-v1.0.0.json#",
  "volumeProperties": [{
    "effectiveRange": [-100.0, 500.0],
    "isoSurfaceValues": [0.0],
    "independentComponents": true,
    "interpolationType": "linear",
    "useClippedVoxelIntensity": false,
    "components": [{
      "componentWeight": 1.0, "shade": true,
      "lighting": {"diffuse": 0.8, "ambient": 0.15, "specular": 0.3, "specularPower": 12.0},
      "disableGradientOpacity": false,
      "scalarOpacityUnitDistance": 2.0,
      "rgbTransferFunction": {"type": "colorTransferFunction", "points": [
        {"x": 0.0, "color": [0.5, 0.1, 0.1], "midpoint": 0.5, "sharpness": 0.0},
        {"x": 300.0, "color": [1.0, 0.9, 0.8], "midpoint": 0.5, "sharpness": 0.0}]},
      "scalarOpacity": {"type": "piecewiseLinearFunction", "points": [
        {"x": 300.0, "y": 0.75, "midpoint": 0.5, "sharpness": 0.0},
        {"x": 100.0, "y": 0.0, "midpoint": 0.5, "sharpness": 0.0}]},
      "gradientOpacity": {"type": "piecewiseLinearFunction", "points": [
        {"x": 10.0, "y": 0.0}, {"x": 50.0, "y": 1.0}, {"x": 255.0, "y": 1.0}]}
    }]}]})";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

class AppearanceFileTest : public ::testing::Test {
 protected:
  AppearanceFileTest()
      : path_(std::filesystem::temp_directory_path() /
              ("sonde_look_" + std::to_string(::getpid()) + ".look")) {}
  ~AppearanceFileTest() override { std::filesystem::remove(path_); }
  Result<AppearanceFile> read(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    return read_appearance_file(path_);
  }
  static AppearanceFile full_appearance() {
    render::TransferComponent edge{
        "edge \"α\"", {{-100.5, {0, 0.1, 1}, 0, 0.01}, {1e5, {1, 1, 0.3}, 0.999, 1}}, {}};
    edge.gradient = render::GradientWindow{5, 10, kInfinity, kInfinity};
    const render::TransferComponent haze{
        "haze", {{0, {1, 1, 1}, 1e-9, 0}, {0.001, {1, 1, 1}, 1.0 / 3, 0.1}}, {}};
    render::Shading shading;
    shading.style = render::ShadingStyle::kGooch;
    shading.emphasis = 0.75;
    render::Cutaway cutaway;
    cutaway.theta1_rad = 20 * kDeg;
    cutaway.theta2_rad = 40 * kDeg;
    cutaway.overlay_mm = kInfinity;
    cutaway.around_needle = true;
    return {*render::TransferFunction::blend("my look", {edge, haze}), shading, cutaway,
            render::ValueRange{12, 345.5}};
  }
  std::filesystem::path path_;
};

TEST_F(AppearanceFileTest, ReadsBackTheWrittenValues) {
  const AppearanceFile appearance = full_appearance();
  ASSERT_TRUE(write_appearance_file(path_, appearance).has_value());
  const auto again = read_appearance_file(path_);
  ASSERT_TRUE(test::has_value(again));
  EXPECT_TRUE(render::same_classification(again->transfer, appearance.transfer));
  EXPECT_EQ(again->transfer.name(), "my look");
  EXPECT_EQ(again->transfer.components()[0].name, "edge \"α\"");
  EXPECT_EQ(again->shading->style, render::ShadingStyle::kGooch);
  EXPECT_EQ(again->shading->emphasis, 0.75);
  ASSERT_TRUE(again->cutaway && *again->cutaway);
  EXPECT_NEAR((*again->cutaway)->theta1_rad, 20 * kDeg, 1e-15);
  EXPECT_EQ((*again->cutaway)->overlay_mm, kInfinity);
  EXPECT_TRUE((*again->cutaway)->around_needle);
  EXPECT_EQ(again->value_range->high, 345.5);
  EXPECT_EQ(to_json_text(*again), to_json_text(appearance)) << "and written the same again";
}

TEST_F(AppearanceFileTest, PartsMissingInTheFileAreAbsent) {
  AppearanceFile appearance = full_appearance();
  appearance.shading.reset();
  appearance.cutaway.reset();
  appearance.value_range.reset();
  auto again = read(to_json_text(appearance));
  ASSERT_TRUE(test::has_value(again));
  EXPECT_FALSE(again->shading || again->cutaway || again->value_range);
  appearance.cutaway.emplace();  // Present, without a cutaway.
  again = read(to_json_text(appearance));
  ASSERT_TRUE(test::has_value(again));
  ASSERT_TRUE(again->cutaway.has_value());
  EXPECT_FALSE(again->cutaway->has_value());
}

TEST_F(AppearanceFileTest, IsScaledToTheValueRangeOfAnotherVolume) {
  VoxelGrid grid;
  grid.size = {100, 10, 10};
  std::vector<std::int16_t> values(grid.voxel_count(), 0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i % 100 > 50) values[i] = static_cast<std::int16_t>(1000 + 10 * (i % 100));
  }
  const auto volume = *Volume::create(grid, values, "other scanner");
  AppearanceFile appearance = full_appearance();
  const auto there = appearance_for(appearance, volume)->transfer;
  const auto range = render::value_range(volume);
  for (const double share : {0.0, 0.4, 1.0}) {
    const double here = 12 + share * (345.5 - 12);
    const double value = range.low + share * (range.high - range.low);
    EXPECT_NEAR(there.at(value, 1e6).tau_per_mm, appearance.transfer.at(here, 1e6).tau_per_mm,
                1e-9);
  }
  appearance.value_range.reset();
  EXPECT_TRUE(render::same_classification(appearance_for(appearance, volume)->transfer,
                                          appearance.transfer));
}

TEST_F(AppearanceFileTest, ReadsVpFilesOfSlicer) {
  const auto appearance = read(kVp);
  ASSERT_TRUE(test::has_value(appearance));
  const auto opacity = [&](double hu) {
    return -std::expm1(-appearance->transfer.at(hu).tau_per_mm);
  };
  EXPECT_NEAR(opacity(45.3791), 0.169643, 1e-12);
  EXPECT_NEAR(opacity(3071), 0.616071, 1e-12);
  EXPECT_EQ(opacity(-1000), 0);
  EXPECT_NEAR(
      (appearance->transfer.at(139.919).rgb - Eigen::Vector3d(1, 0.894893, 0.894893)).norm(), 0,
      1e-12);
  EXPECT_FALSE(appearance->transfer.uses_gradient()) << "a gradient opacity of 1 throughout";
  EXPECT_EQ(appearance->transfer.at(45.3791).importance, 0.5);
  EXPECT_TRUE(appearance->shading->enabled);
  EXPECT_EQ(appearance->shading->shininess, 10);
}

TEST_F(AppearanceFileTest, KeepsStepsInCurvesOfSlicer) {
  const std::string opacities =
      "14 -3024 0 -86.9767 0 45.3791 0.169643 139.919 0.589286 347.907 0.607143 1224.16 0.607143 "
      "3071 0.616071";
  const auto appearance = read(replaced(kVp, opacities, "8 -1000 0 100 0 100 0.5 300 0.5"));
  ASSERT_TRUE(test::has_value(appearance));
  const auto opacity = [&](double hu) {
    return -std::expm1(-appearance->transfer.at(hu).tau_per_mm);
  };
  EXPECT_EQ(opacity(-500), 0);
  EXPECT_EQ(opacity(99.9), 0);
  EXPECT_EQ(opacity(100), 0);
  EXPECT_NEAR(opacity(100.1), 0.5, 1e-12);
  EXPECT_NEAR(opacity(250), 0.5, 1e-12);
}

TEST_F(AppearanceFileTest, OpacitiesOfShortDistancesStayBelowOne) {
  const auto appearance = read(replaced(replaced(kVpJson, "Distance\": 2.0", "Distance\": 0.2"),
                                        "\"y\": 0.75", "\"y\": 1.0"));
  ASSERT_TRUE(test::has_value(appearance));
  EXPECT_NEAR(-std::expm1(-appearance->transfer.at(300, 100).tau_per_mm), 0.9999, 1e-9);
}

TEST_F(AppearanceFileTest, ReadsJsonFilesOfSlicer) {
  const auto appearance = read(kVpJson);
  ASSERT_TRUE(test::has_value(appearance));
  // 0.75 over 2 mm is 0.5 over 1 mm.
  EXPECT_NEAR(-std::expm1(-appearance->transfer.at(300, 100).tau_per_mm), 0.5, 1e-12);
  EXPECT_EQ(appearance->transfer.at(300, 10).tau_per_mm, 0);
  EXPECT_NEAR(appearance->transfer.at(300, 30).tau_per_mm,
              0.5 * appearance->transfer.at(300, 60).tau_per_mm, 1e-12);
  EXPECT_EQ(appearance->shading->ambient, 0.15);
}

TEST_F(AppearanceFileTest, AVolumePropertyWithoutShadeIsNotShaded) {
  EXPECT_TRUE(read(kVpJson)->shading->enabled);
  const auto silent = read(replaced(kVpJson, "\"shade\": true,", ""));
  ASSERT_TRUE(test::has_value(silent));
  EXPECT_FALSE(silent->shading->enabled);
  EXPECT_TRUE(read(replaced(kVpJson, "\"interpolationType\": \"linear\",", "")).has_value());
}

TEST_F(AppearanceFileTest, AcceptsImportanceRules) {
  const auto appearance = read(kVp);
  ASSERT_TRUE(test::has_value(appearance));
  const auto f =
      render::with_importance(appearance->transfer, {{-3024, 100, 0.05}, {200, 3071, 1}});
  ASSERT_TRUE(test::has_value(f));
  EXPECT_EQ(f->at(45).importance, 0.05);
  EXPECT_EQ(f->at(150).importance, 0.5);
  EXPECT_EQ(f->at(400).importance, 1);
  EXPECT_NEAR(f->at(45).tau_per_mm, appearance->transfer.at(45).tau_per_mm, 1e-12);
}

TEST_F(AppearanceFileTest, RejectsBrokenSlicerFiles) {
  const auto refused = [&](const std::string& text, std::initializer_list<std::string> pieces) {
    return test::rejects(read(text), ErrorCode::kMalformedData, pieces);
  };
  EXPECT_TRUE(refused("hello", {"9 lines", "1"}));
  EXPECT_TRUE(
      refused(replaced(kVp, "14 -3024", "15 -3024"), {"scalar opacity", "count 15 and 14"}));
  EXPECT_TRUE(refused(replaced(kVp, "0.169643", "nan"), {"scalar opacity", "finite", "nan"}));
  EXPECT_TRUE(refused(replaced(kVp, "0.169643", "1e999"), {"scalar opacity", "finite"}));
  EXPECT_TRUE(refused(replaced(kVp, "0.169643", "1.2"), {"scalar opacity", "[0, 1]", "1.2"}));
  EXPECT_TRUE(refused(replaced(kVp, "0.25098 1 45", "-1 1 45"), {"colours", "[0, 1]", "-1"}));
  EXPECT_TRUE(refused(replaced(kVp, "0.9\n", "x\n"), {"diffuse", "x"}));
  EXPECT_TRUE(refused("0" + kVp.substr(1), {"interpolation: expected 1, linear, found 0"}));
  EXPECT_TRUE(refused(replaced(kVpJson, "\"linear\"", "\"nearest\""),
                      {"interpolationType: expected \"linear\", found \"nearest\""}));
  EXPECT_TRUE(refused(
      replaced(kVpJson, "\"independentComponents\": true", "\"independentComponents\": false"),
      {"independentComponents: expected true", "found false"}));
  EXPECT_TRUE(refused(replaced(kVpJson, "\"rgbTransferFunction\": {",
                               "\"rgbTransferFunction\": {\"colorSpace\": \"hsv\", "),
                      {"colorSpace: expected \"rgb\", found \"hsv\""}));
  EXPECT_TRUE(
      refused(replaced(kVpJson, "\"y\": 0.75", "\"y\": null"), {"scalarOpacity", "x and y"}));
  EXPECT_TRUE(refused(replaced(kVpJson, "\"y\": 0.75", "\"y\": 7"), {"scalar opacity", "[0, 1]"}));
  EXPECT_TRUE(refused(replaced(kVpJson, "[0.5, 0.1, 0.1]", "[0.5, 0.1]"), {"three colours"}));
  EXPECT_TRUE(refused(replaced(kVpJson, "Distance\": 2.0", "Distance\": 0"),
                      {"scalarOpacityUnitDistance"}));
  EXPECT_TRUE(refused(replaced(kVp, "14 -3024", "14 -1e300"), {"scalar opacity", "1e9"}));
  EXPECT_TRUE(refused(replaced(kVpJson,
                               "{\"diffuse\": 0.8, \"ambient\": 0.15, \"specular\": 0.3, "
                               "\"specularPower\": 12.0}",
                               "[1, 2]"),
                      {"lighting", "object", "[1,2]"}));
  EXPECT_TRUE(refused(R"({"volumeProperties": []})", {"one volume property"}));
  EXPECT_TRUE(refused(R"({"volumeProperties": [{"components": 3}]})", {"one volume property"}));
}

TEST_F(AppearanceFileTest, RejectsFeaturesOfSlicerThatSondeLacks) {
  const auto refused = [&](const std::string& text, std::initializer_list<std::string> pieces) {
    return test::rejects(read(text), ErrorCode::kUnsupportedData, pieces);
  };
  EXPECT_TRUE(refused(replaced(kVp, "4 0 1 255 1", "6 0 0.1 50 0.5 255 1"), {"gradient opacity"}));
  EXPECT_TRUE(
      refused(replaced(kVpJson, "\"y\": 0.75, \"midpoint\": 0.5", "\"y\": 0.75, \"midpoint\": 0.3"),
              {"midpoint"}));
  EXPECT_TRUE(refused(R"({"volumeProperties": [{"components": [{}, {}]}]})", {"components", "2"}));
}

TEST_F(AppearanceFileTest, RejectsNodesThatBecomeEqualOnAVolume) {
  AppearanceFile appearance = full_appearance();
  appearance.value_range = render::ValueRange{-1e308, 1e308};
  VoxelGrid grid;
  grid.size = {2, 1, 1};
  const auto volume = *Volume::create(grid, {0, 100}, "two voxels");
  EXPECT_TRUE(test::rejects(appearance_for(appearance, volume), ErrorCode::kMalformedData,
                            {"value_range", "node"}));
}

TEST_F(AppearanceFileTest, NamesAnglesInTheUnitsOfTheFile) {
  const std::string good = to_json_text(full_appearance());
  const auto at = good.find("\"theta1_deg\": ");
  ASSERT_NE(at, std::string::npos);
  const auto end = good.find_first_of(",\n", at);
  for (const auto& [degrees, expected] :
       {std::pair("80.0", "at most theta2_deg"), std::pair("60.0", "at most theta2_deg"),
        std::pair("-3.0", "(0, 90)")}) {
    std::string text = good;
    text.replace(at, end - at, "\"theta1_deg\": " + std::string(degrees));
    EXPECT_TRUE(test::rejects(read(text), ErrorCode::kMalformedData,
                              {"cutaway.theta1_deg", expected, "found " + std::string(degrees)}))
        << degrees;
  }
}

TEST_F(AppearanceFileTest, RecognisesFilesByTheirNameAndText) {
  const std::string mark = "\xef\xbb\xbf";
  for (const std::string& good : {to_json_text(full_appearance()), kVp, kVpJson}) {
    EXPECT_TRUE(test::has_value(read(mark + good)));
  }
  for (const std::string& empty : {std::string(), mark, std::string(" \r\n")}) {
    EXPECT_TRUE(test::rejects(read(empty), ErrorCode::kMalformedData,
                              {path_.string(), "found an empty file"}));
  }
  const auto json = path_.string() + ".json";
  for (const auto& [text, said] : {std::pair("", "an empty file"),
                                   {"hello", "expected JSON"},
                                   {"[]", "expected an object"},
                                   {"3", "expected an object"}}) {
    std::ofstream(json) << text;
    EXPECT_TRUE(test::rejects(read_appearance_file(json), ErrorCode::kMalformedData, {json, said}));
  }
  std::filesystem::remove(json);
}

TEST_F(AppearanceFileTest, RejectsNodesWithoutAValueOrAnOpacity) {
  const auto node = [](const std::string& members) {
    return R"({"sonde_look": 1, "components": [{"name": "a", "nodes": [{"value": 0,)"
           R"("opacity_per_mm": 0}, {)" +
           members + "}]}]}";
  };
  EXPECT_TRUE(test::has_value(read(node(R"("value": 9, "opacity_per_mm": 0.1)"))));
  EXPECT_TRUE(test::rejects(read(node(R"("opacity_per_mm": 0.1)")), ErrorCode::kMalformedData,
                            {"components[0].nodes[1].value", "found nothing"}));
  EXPECT_TRUE(test::rejects(read(node(R"("value": 9)")), ErrorCode::kMalformedData,
                            {"components[0].nodes[1].opacity_per_mm", "found nothing"}));
}

TEST_F(AppearanceFileTest, RejectsBrokenAppearances) {
  const std::string good = to_json_text(full_appearance());
  const auto refused = [&](const std::string& text, std::initializer_list<std::string> pieces) {
    return test::rejects(read(text), ErrorCode::kMalformedData, pieces);
  };
  EXPECT_TRUE(refused("{", {path_.string(), "expected JSON"}));
  EXPECT_TRUE(refused("{}", {"sonde_look", "expected 1"}));
  EXPECT_TRUE(refused(replaced(good, "\"sonde_look\": 1", "\"sonde_look\": 2"), {"expected 1"}));
  EXPECT_TRUE(refused(replaced(good, "\"emphasis\"", "\"emphasys\""), {"emphasys", "no such"}));
  EXPECT_TRUE(refused(replaced(good, "0.75", "1.75"), {"shading.emphasis", "1.75"}));
  EXPECT_TRUE(refused(replaced(good, "0.75", "1e999"), {"expected JSON"}));
  EXPECT_TRUE(refused(replaced(good, "\"gooch\"", "\"flat\""), {"style", "phong or gooch"}));
  EXPECT_TRUE(refused(replaced(good, "345.5", "12.0"), {"value_range", "in order"}));
  EXPECT_TRUE(refused(replaced(good, "\"importance\": 0.01", "\"importance\": 2"),
                      {"importance in [0, 1]", "2"}));
  EXPECT_TRUE(refused(replaced(good, "\"opacity_per_mm\": 0.999", "\"opacity_per_mm\": 1"),
                      {"opacity of 1 mm", "1"}));
  EXPECT_TRUE(refused(replaced(good, "\"value\": 100000.0", "\"value\": -100.5"), {"node 1"}));
  EXPECT_TRUE(
      refused(replaced(good, "\"components\": [", "\"components\": [3,"), {"components[0]"}));
  EXPECT_TRUE(refused("{\"a\":" + std::string(100000, '[') + "}", {"levels deep"}));
  EXPECT_FALSE(read(std::string((1 << 20) + 1, ' ')).has_value()) << "too large";
  EXPECT_TRUE(
      test::rejects(read_appearance_file("/nowhere/look.json"), ErrorCode::kNotFound, {"look"}));
}

TEST_F(AppearanceFileTest, MutatedFilesCauseNoCrash) {
  std::mt19937 random(31);
  int read_well = 0;
  int refused = 0;
  for (const std::string& good : {to_json_text(full_appearance()), kVp, kVpJson}) {
    for (int trial = 0; trial < 300; ++trial) {
      std::string text = good;
      for (int i = 0; i < 1 + trial % 4; ++i) {
        const auto at = random() % text.size();
        switch (random() % 4) {
          case 0:
            text[at] = static_cast<char>(random() % 256);
            break;
          case 1:
            text.erase(at, 1 + random() % 20);
            break;
          case 2:
            text.insert(at, text.substr(random() % text.size(), random() % 30));
            break;
          default:
            text.resize(at);
        }
        if (text.empty()) text = " ";
      }
      const auto appearance = read(text);
      if (!appearance) {
        ++refused;
        EXPECT_EQ(appearance.error().message.rfind(path_.string(), 0), 0U)
            << appearance.error().message;
        continue;
      }
      ++read_well;
      for (const double hu : {-1e4, 0.0, 50.0, 1e4}) {
        const auto s = appearance->transfer.at(hu, 20);
        EXPECT_TRUE(s.rgb.allFinite() && s.tau_per_mm >= 0 && std::isfinite(s.tau_per_mm));
      }
    }
  }
  EXPECT_GT(refused, 300);
  EXPECT_GT(read_well, 5);
}

}  // namespace
}  // namespace nav::app
