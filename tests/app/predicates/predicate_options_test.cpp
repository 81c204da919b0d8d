// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_options.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "app/options/session_config.hpp"
#include "app/predicates/predicate_labels.hpp"
#include "app/predicates/predicate_scribbles.hpp"
#include "app/predicates/predicate_volume.hpp"
#include "app/predicates/predicate_white.hpp"
#include "io/ct.hpp"
#include "nav/diagnostics.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

using render::features::Paint;
using E = render::PredicateExpression;

/// Volume with a dark half and a bright half.
std::shared_ptr<const StoredVolume> halves() {
  VoxelGrid grid;
  grid.size = {12, 10, 8};
  std::vector<std::int16_t> voxels(grid.voxel_count());
  for (std::size_t n = 0; n < voxels.size(); ++n) voxels[n] = n % 12 < 6 ? 40 : 200;
  return std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, std::move(voxels), "halves"));
}

render::Scene scene_of_halves() {
  render::PredicateScene predicates;
  predicates.model = {
      {{"bright", E::kind("intensity", {0.5, 1})}, {"dark", E::kind("intensity", {0, 0.5})}},
      *render::PredicateHistogram::create({{0.5, 0, 0}, {0.5, 90, 0}})};
  render::Scene scene{.ct = halves(),
                      .transfer = *render::TransferFunction::create(
                          "grey", {{0, {1, 1, 1}, 0, 1}, {1, {1, 1, 1}, 0, 1}})};
  scene.predicates = predicates;
  return scene;
}

TEST(PredicateOptionsTest, EditsKeepTheSumOfTheHistogram) {
  auto model = *render::preset_predicates("carotid-vessel");
  const auto drag = parse_importance("vessel=0.9");
  const auto paint = parse_colour("vessel=200:0.5");
  ASSERT_TRUE(test::has_value(drag));
  ASSERT_TRUE(test::has_value(paint));
  ASSERT_TRUE(test::has_value(apply_edits({*drag, *paint}, model)));
  const auto& bars = model.histogram.bars();
  EXPECT_NEAR(bars[0].importance, 0.9, 1e-12);
  EXPECT_EQ(bars[0].hue_deg, 200);
  EXPECT_EQ(bars[0].saturation, 0.5);
  EXPECT_NEAR(bars[0].importance + bars[1].importance + bars[2].importance, 1, 1e-12);
  EXPECT_NEAR(bars[1].importance / bars[2].importance, 5, 1e-9) << "the others keep proportions";
  EXPECT_TRUE(test::rejects(apply_edits({{"liver", 0.5}}, model), ErrorCode::kUsage,
                            {"histogram", "vessel, tissue, skin", "'liver'"}));
  for (const char* text : {"vessel", "=1", "vessel=", "vessel=x", "vessel=1:2", "vessel=nan"}) {
    EXPECT_TRUE(test::rejects(parse_importance(text), ErrorCode::kUsage, {"--importance", text}));
  }
  EXPECT_TRUE(test::rejects(parse_colour("a=1"), ErrorCode::kUsage, {"NAME=HUE:SATURATION"}));
}

TEST(PredicateOptionsTest, RejectsInvalidNumbersByKey) {
  const auto refused = [](auto change, std::initializer_list<std::string> pieces) {
    SessionConfig config;
    change(config.predicates);
    return test::rejects(validate(config), ErrorCode::kUsage, pieces);
  };
  EXPECT_TRUE(test::has_value(validate(SessionConfig{})));
  EXPECT_TRUE(refused([](auto& o) { o.white = -1; }, {"predicates.white", "more than black"}));
  EXPECT_TRUE(refused([](auto& o) { o.scribble_share = 0; }, {"scribble_share"}));
  EXPECT_TRUE(refused([](auto& o) { o.black = std::nan(""); }, {"black", "nan"}));
  EXPECT_TRUE(refused([](auto& o) { o.into_ct = Eigen::Vector3d::Zero(); }, {"into", "not all 0"}));
  EXPECT_TRUE(refused([](auto& o) { o.into_ct = o.apex_ct = Eigen::Vector3d::UnitX(); },
                      {"apex_mm", "into"}));
  EXPECT_TRUE(refused([](auto& o) { o.target = Eigen::Vector4d::Zero(); }, {"target", "radius"}));
  EXPECT_TRUE(refused([](auto& o) { o.needle.emplace().setZero(); }, {"needle", "apart"}));
  EXPECT_TRUE(refused([](auto& o) { o.apex_ct = Eigen::Vector3d(1e300, 0, 0); },
                      {"apex_mm", "10000000 mm", "1e+300"}));
  EXPECT_TRUE(refused([](auto& o) { o.target = Eigen::Vector4d(0, 1e300, 0, 1); }, {"target"}));
  EXPECT_TRUE(refused([](auto& o) { o.needle.emplace().setConstant(1e300); }, {"needle"}));
  EXPECT_TRUE(refused([](auto& o) { o.hue_mean = "square"; }, {"hue_mean", "linear", "square"}));
  EXPECT_TRUE(refused([](auto& o) { o.unknown = 65536; }, {"unknown", "32767", "65536"}));
  EXPECT_TRUE(refused([](auto& o) { o.unknown = -40000; }, {"unknown", "-32768", "-40000"}));
  PredicateOptions far;
  far.into_ct = far.from = Eigen::Vector3d(1e300, 1e300, 0);
  EXPECT_TRUE(test::has_value(validate(far))) << "directions may have any length";
  EXPECT_TRUE(refused(
      [](auto& o) {
        o.smallest_radius_mm = 3;
        o.largest_radius_mm = 2;
      },
      {"smallest_radius_mm", "largest_radius_mm"}));
}

TEST(PredicateOptionsTest, HuesAreTakenModulo360) {
  PredicateOptions options;
  options.set_up = "carotid-vessel";
  for (const char* text : {"vessel=400:0.5", "vessel=-320:0.5", "vessel=4000:0.5"}) {
    options.histogram = {*parse_colour(text)};
    EXPECT_TRUE(test::has_value(validate(options))) << text;
    const auto file = set_up_of(options);
    ASSERT_TRUE(test::has_value(file)) << text;
    EXPECT_EQ(file->model.histogram.bars()[0].hue_deg, 40) << text;
  }
  options.histogram = {{"vessel", {}, std::nan(""), {}}};
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage,
                            {"predicates.histogram.hue_deg", "finite"}));
  options.histogram = {{"vessel", {}, {}, 1.5}};
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage,
                            {"predicates.histogram.saturation", "0 to 1", "1.5"}));
}

TEST(PredicateOptionsTest, RejectsASetThatIsNeitherFileNorPresetByKey) {
  PredicateOptions options;
  options.set_up = "nope.json";
  EXPECT_TRUE(test::rejects(set_up_of(options), ErrorCode::kUsage,
                            {"predicates.set_up: expected a file, or a predicate preset",
                             "carotid-vessel", "nope.json"}));
}

/// Warning about a volume's voxels above white; empty for none.
std::string said_of_white(const std::vector<std::int16_t>& voxels,
                          const PredicateOptions& options) {
  CollectingDiagnostics diagnostics;
  warn_of_white("us.mha", voxels, options.white.value_or(255), options.unknown, diagnostics);
  const auto entries = diagnostics.entries();
  if (entries.empty()) return "";
  EXPECT_EQ(entries.size(), 1U);
  EXPECT_EQ(entries[0].severity, Severity::kWarning);
  EXPECT_EQ(entries[0].source, "us.mha");
  return entries[0].message;
}

TEST(PredicateWhiteTest, WarnsOfManyVoxelsAboveWhiteAndProposesAWhite) {
  PredicateOptions options;  // White 255.
  std::vector<std::int16_t> voxels(1000, 255);
  EXPECT_EQ(said_of_white(voxels, options), "");
  EXPECT_EQ(said_of_white({}, options), "");
  for (int n = 0; n < 50; ++n) voxels[static_cast<std::size_t>(n)] = 256;
  EXPECT_EQ(said_of_white(voxels, options), "") << "just 5 %";
  // 1000 to 1299, and one of 14600.
  for (int n = 0; n < 300; ++n)
    voxels[static_cast<std::size_t>(n)] = static_cast<std::int16_t>(1000 + n);
  voxels[0] = 14600;
  // Above 1290 are 1291 to 1299 and 14600: 1 % of all.
  const std::string said = said_of_white(voxels, options);
  for (const char* piece : {"(255)", "found 30 %", "up to 14600", "--white 1290"}) {
    EXPECT_NE(said.find(piece), std::string::npos) << said;
  }
  options.white = 1290;
  EXPECT_EQ(said_of_white(voxels, options), "");
}

TEST(IntensityWindowTest, IsThatOf8BitsUnlessTheVolumeIsDimOrBright) {
  const auto ramp = [](int low, int high) {
    std::vector<std::int16_t> voxels(1000, static_cast<std::int16_t>(low));
    for (int n = 0; n < 1000; ++n) {
      voxels.push_back(static_cast<std::int16_t>(low + 1 + (high - low - 1) * n / 999));
    }
    return voxels;
  };
  const auto usual = intensity_window(ramp(0, 220), {});
  EXPECT_FALSE(usual.by_percentiles);
  EXPECT_EQ(usual.black, 0);
  EXPECT_EQ(usual.white, 255);
  const auto dim = intensity_window(ramp(0, 60), {});
  EXPECT_TRUE(dim.by_percentiles);
  EXPECT_NEAR(dim.black, 1, 1);
  EXPECT_NEAR(dim.white, 60, 1);
  const auto bright = intensity_window(ramp(100, 4000), {});
  EXPECT_TRUE(bright.by_percentiles);
  EXPECT_NEAR(bright.black, 138, 3) << "1 % of 3900 above 100, between two steps";
  EXPECT_NEAR(bright.white, 3981, 5);
  // Unknown voxels and volumes of one value decide nothing.
  auto voxels = ramp(0, 60);
  voxels.insert(voxels.end(), 5000, std::int16_t{-1});
  const auto known = intensity_window(voxels, -1);
  EXPECT_EQ(known.white, dim.white);
  EXPECT_EQ(known.black, dim.black);
  EXPECT_FALSE(intensity_window(std::vector<std::int16_t>(9, 7), {}).by_percentiles);
  EXPECT_FALSE(intensity_window({}, {}).by_percentiles);
}

TEST(PredicateOptionsTest, AFloorIsParsedAndApplied) {
  auto model = *render::preset_predicates("carotid-vessel");
  const auto edit = parse_floor("vessel=0.4");
  ASSERT_TRUE(test::has_value(edit));
  ASSERT_TRUE(test::has_value(apply_edits({*edit}, model)));
  EXPECT_EQ(model.entries[0].floor, 0.4);
  EXPECT_EQ(model.entries[1].floor, 0);
  for (const char* text : {"vessel", "vessel=", "vessel=nan", "=1"}) {
    EXPECT_TRUE(test::rejects(parse_floor(text), ErrorCode::kUsage, {"--floor", text}));
  }
  PredicateOptions options;
  options.histogram = {{.entry = "vessel", .floor = 1.5}};
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"floor", "0 to 1", "1.5"}));
}

TEST(PredicateWhiteTest, UnknownVoxelsDoNotCount) {
  PredicateOptions options;
  std::vector<std::int16_t> voxels(1000, 32000);
  std::fill_n(voxels.begin(), 600, std::int16_t{10});
  options.unknown = 32000;
  EXPECT_EQ(said_of_white(voxels, options), "");
  options.unknown = 10;
  EXPECT_NE(said_of_white(voxels, options).find("found 100 %, up to 32000"), std::string::npos);
}

TEST(PredicateOptionsTest, OptionsOverrideThePredicateSetAndContradictionsAreRejected) {
  PredicateOptions options;  // carotid-vessel: dark vessels of 2 to 4.5 mm.
  options.bright_vessels = true;
  options.hue_mean = "linear";
  const auto bright = set_up_of(options);
  ASSERT_TRUE(test::has_value(bright));
  EXPECT_TRUE(bright->vessels.bright);
  EXPECT_EQ(bright->hue_mean, render::spec::HueMean::kLinear);
  const auto path = std::filesystem::temp_directory_path() /
                    ("sonde_bright_" + std::to_string(getpid()) + ".json");
  ASSERT_TRUE(test::has_value(write_predicate_file(path, *bright)));
  options.set_up = path.string();
  options.bright_vessels = false;
  options.hue_mean.reset();
  EXPECT_FALSE(set_up_of(options)->vessels.bright);
  EXPECT_EQ(set_up_of(options)->hue_mean, render::spec::HueMean::kLinear);
  options.bright_vessels.reset();
  EXPECT_TRUE(set_up_of(options)->vessels.bright);
  options.smallest_radius_mm = 6;
  EXPECT_TRUE(test::rejects(set_up_of(options), ErrorCode::kUsage,
                            {"smallest_radius_mm", "at most the largest radius, 4.5", "found 6"}));
  options.smallest_radius_mm.reset();
  options.largest_radius_mm = 1;
  EXPECT_TRUE(test::rejects(set_up_of(options), ErrorCode::kUsage,
                            {"largest_radius_mm", "at least the smallest radius, 2", "found 1"}));
  std::filesystem::remove(path);
}

TEST(PredicateOptionsTest, ASingleBarKeepsAllImportance) {
  render::PredicateModel one;
  one.entries.push_back({"vessel", render::PredicateExpression::kind("intensity")});
  one.histogram = *render::PredicateHistogram::create({{1, 0, 0}});
  EXPECT_TRUE(test::rejects(apply_edits({{"vessel", 0.2}}, one), ErrorCode::kUsage,
                            {"histogram.importance", "only one predicate", "0.2"}));
  EXPECT_TRUE(test::has_value(apply_edits({{"vessel", 1.0}}, one)));
}

TEST(PredicateScribblesTest, ParsesStrokesAndFindsTheirSlice) {
  const auto stroke = parse_stroke("--show", Paint::kShow, "0,0,0 4,0,0 4,3,3 radius=0.7");
  ASSERT_TRUE(test::has_value(stroke));
  EXPECT_EQ(stroke->points.size(), 3U);
  EXPECT_EQ(stroke->radius_mm, 0.7);
  EXPECT_NEAR(std::abs(stroke->plane_normal.v.dot(Eigen::Vector3d(0, 1, -1).normalized())), 1,
              1e-12);
  const auto turned = parse_stroke("--hide", Paint::kHide, "1,2,3 normal=1,0,0");
  ASSERT_TRUE(test::has_value(turned));
  EXPECT_EQ(turned->plane_normal.v, Eigen::Vector3d::UnitX());
  for (const char* text :
       {"", "1,2", "1,2,3,4", "1,2,x", "radius=1", "1,2,3 radius=x", "1,2,3 normal=1,2"}) {
    EXPECT_TRUE(test::rejects(parse_stroke("--show", Paint::kShow, text), ErrorCode::kUsage,
                              {"--show", std::string("'") + text + "'"}));
  }
  const auto thick = parse_stroke("--show", Paint::kShow, "1,2,3 normal=0,0,1 thickness=3");
  ASSERT_TRUE(test::has_value(thick));
  EXPECT_EQ(thick->half_thickness_mm, 1.5);
  struct Bad {
    const char *text, *member, *expected, *found;
  };
  for (const auto& [text, member, expected, found] :
       {Bad{"1,2,3 radius=-1", "radius_mm", "(0, 1000]", "-1"},
        Bad{"1,2,3 thickness=-2", "thickness_mm", "[0, 2000]", "-2"},
        Bad{"1,2,3 normal=0,0,0", "normal", "not all 0", "[0.0,0.0,0.0]"},
        Bad{"1e300,2,3", "points_mm", "1e6 mm", "1e+300"}}) {
    const auto refused = parse_stroke("--hide", Paint::kHide, text);
    EXPECT_TRUE(
        test::rejects(refused, ErrorCode::kUsage, {"--hide", member, expected, found, text}));
  }
}

TEST(PredicateScribblesTest, StrokesChangeTheHistogram) {
  const auto scene = scene_of_halves();
  const auto show = parse_stroke("--show", Paint::kShow, "8,1,3 8,8,3 radius=0.4 normal=0,0,1");
  const auto hide = parse_stroke("--hide", Paint::kHide, "2,1,3 2,8,3 radius=0.4 normal=0,0,1");
  const auto outcome = scribble(scene, {*show, *hide}, 0.25);
  ASSERT_TRUE(test::has_value(outcome));
  EXPECT_EQ(outcome->shown, 8U);
  EXPECT_EQ(outcome->hidden, 8U);
  EXPECT_TRUE(outcome->decisive);
  // m = 0.25 · (8, -8) / 16, whose mean is 0.
  EXPECT_NEAR(outcome->histogram.bars()[0].importance, 0.625, 1e-12);
  EXPECT_NEAR(outcome->histogram.bars()[1].importance, 0.375, 1e-12);
  // Both strokes are in the bright half, so no predicate tells them apart.
  const auto there = parse_stroke("--hide", Paint::kHide, "10,1,3 10,8,3 radius=0.4 normal=0,0,1");
  const auto alike = scribble(scene, {*show, *there}, 0.25);
  ASSERT_TRUE(test::has_value(alike));
  EXPECT_FALSE(alike->decisive);
  EXPECT_TRUE(alike->histogram.bars() == scene.predicates->model.histogram.bars());
  // A single predicate keeps all importance.
  auto one = scene;
  one.predicates->model.entries.pop_back();
  one.predicates->model.histogram = *render::PredicateHistogram::create({{1, 0, 0.5}});
  const auto nothing = scribble(one, {*show, *hide}, 0.25);
  ASSERT_TRUE(test::has_value(nothing));
  EXPECT_FALSE(nothing->decisive);
  const auto off = parse_stroke("--show", Paint::kShow, "8,1,3 8,8,4 normal=0,0,1");
  for (const auto& refused : {scribble(scene, {*show, *off}, 0.25).error(),
                              check_strokes({*show, *off}, scene.ct->grid()).error()}) {
    EXPECT_EQ(refused.code, ErrorCode::kUsage);
    for (const char* piece : {"stroke 2", "point 2 at (8 8 4)", "1 mm away"}) {
      EXPECT_NE(refused.message.find(piece), std::string::npos) << refused.message;
    }
  }
  const auto outside = parse_stroke("--show", Paint::kShow, "500,0,0");
  EXPECT_TRUE(test::rejects(scribble(scene, {*show, *outside}, 0.25), ErrorCode::kUsage,
                            {"stroke 2", "found none"}));
}

TEST(PredicateScribblesTest, ReadsFilesAndNamesThePositionOfErrors) {
  const test::TemporaryFolder folder;
  const auto path = folder / "strokes.json";
  const auto read = [&](const std::string& text) {
    std::ofstream(path) << text;
    return read_scribble_file(path);
  };
  const auto strokes = read(R"({"sonde_scribbles": 1, "strokes": [
      {"paint": "hide", "points_mm": [[1, 2, 3], [4, 5, 6]], "normal": [0, 0, 2], "radius_mm": 2,
       "thickness_mm": 1}]})");
  ASSERT_TRUE(test::has_value(strokes));
  EXPECT_EQ(strokes->front().paint, Paint::kHide);
  EXPECT_EQ(strokes->front().half_thickness_mm, 0.5);
  EXPECT_EQ(strokes->front().points[1].mm, Eigen::Vector3d(4, 5, 6));
  const auto rejects = [&](const std::string& text, std::initializer_list<std::string> pieces,
                           ErrorCode code = ErrorCode::kMalformedData) {
    return test::rejects(read(text), code, pieces);
  };
  EXPECT_TRUE(
      rejects(R"({"sonde_scribbles": 2})", {"version 1", "newer"}, ErrorCode::kUnsupportedData));
  EXPECT_TRUE(rejects(R"({"sonde_scribbles": 1})", {"strokes", "at least one"}));
  EXPECT_TRUE(rejects(R"({"sonde_scribbles": 1, "strokes": [{"points_mm": [[1, 2]]}]})",
                      {"strokes[0].points_mm[0]", "3 numbers"}));
  EXPECT_TRUE(
      rejects(R"({"sonde_scribbles": 1, "strokes": [{"points_mm": [[1, 2, 3]], "paint": "blue"}]})",
              {"strokes[0].paint", "show, hide or erase"}));
  EXPECT_TRUE(rejects(R"({"sonde_scribbles": 1, "strokes": [{"points_mm": []}]})",
                      {"strokes[0].points_mm", "at least one point"}));
}

TEST(PredicateLabelsTest, OneFileHasMasksSeveralHaveOneBitEach) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics diagnostics;
  VoxelGrid grid;
  grid.size = {3, 2, 2};
  grid.spacing_mm = {0.3, 0.2, 1};
  const auto write = [&](const char* name, std::vector<std::int16_t> values, const VoxelGrid& on) {
    EXPECT_TRUE(test::has_value(
        io::write_ct_mha(*StoredVolume::create(on, std::move(values), name), folder / name)));
    return folder / name;
  };
  const auto masks = write("masks.mha", {0, 1, 2, 3, 4, 5, 0, 0, 0, 0, 0, 16384}, grid);
  const auto one = read_labels({masks}, grid, diagnostics);
  ASSERT_TRUE(test::has_value(one));
  EXPECT_EQ(one->bits()[3], 3U);
  EXPECT_EQ(one->bits()[11], 16384U);
  const auto bone = write("bone.mha", {0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, grid);
  const auto both = read_labels({masks, bone}, grid, diagnostics);
  ASSERT_TRUE(test::has_value(both));
  EXPECT_EQ(both->bits()[0], 0U);
  EXPECT_EQ(both->bits()[1], 3U);
  EXPECT_EQ(both->bits()[2], 1U);
  VoxelGrid other = grid;
  other.size = {2, 3, 2};
  EXPECT_TRUE(test::rejects(read_labels({masks}, other, diagnostics), ErrorCode::kMalformedData,
                            {"masks.mha", "2 x 3 x 2", "3 x 2 x 2"}));
  other = grid;
  other.origin_mm.x() += 1;
  EXPECT_TRUE(test::rejects(read_labels({masks}, other, diagnostics), ErrorCode::kMalformedData,
                            {"masks.mha", "at (1 0 0)"}));
  const auto negative = write("negative.mha", {0, -5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, grid);
  EXPECT_TRUE(test::rejects(read_labels({negative}, grid, diagnostics), ErrorCode::kMalformedData,
                            {"0 to 4294967295", "-5"}));
}

TEST(PredicateSessionTest, EveryKeySurvivesARoundTripThroughAFile) {
  const test::TemporaryFolder folder;
  const auto path = folder / "session.toml";
  std::ofstream(path) << R"(
[predicates]
volume = "us.mha"
set_up = "mine.json"
labels = ["a.mha", "b.mha"]
scribbles = "strokes.json"
cache = "features"
scribble_share = 0.5
picture = "both.png"
white = 200
into = [0, 1, 0]
target_mm = [1, 2, 3, 4]
largest_radius_mm = 4.5
histogram = [{entry = "vessel", importance = 0.8}, {entry = "skin", hue_deg = 12.0}]
[output]
engine = "reference"
)";
  const auto config = read_session_config(path);
  ASSERT_TRUE(test::has_value(config));
  const PredicateOptions& o = config->predicates;
  EXPECT_EQ(o.volume, folder / "us.mha");
  EXPECT_EQ(o.set_up, (folder / "mine.json").string());
  ASSERT_EQ(o.labels.size(), 2U);
  EXPECT_EQ(o.labels[1], folder / "b.mha");
  EXPECT_EQ(o.cache, folder / "features");
  EXPECT_EQ(o.histogram[0].importance, 0.8);
  EXPECT_EQ(o.histogram[1].hue_deg, 12);
  EXPECT_FALSE(o.histogram[1].importance.has_value());
  EXPECT_EQ(o.target, Eigen::Vector4d(1, 2, 3, 4));
  EXPECT_EQ(config->output.engine, "reference");
  const auto again = folder / "again.toml";
  std::ofstream(again) << *to_toml(*config);
  const auto back = read_session_config(again);
  ASSERT_TRUE(test::has_value(back));
  EXPECT_EQ(*to_toml(*back), *to_toml(*config));
  std::ofstream(path) << "[predicates]\nhistogram = [{entry = \"a\", height = 1}]\n";
  EXPECT_TRUE(test::rejects(read_session_config(path), ErrorCode::kMalformedData,
                            {"predicates.histogram.height"}));
  std::ofstream(path) << "[predicates]\nhistogram = [{importance = 0.5}]\n";
  EXPECT_TRUE(
      test::rejects(read_session_config(path), ErrorCode::kMalformedData,
                    {"session.toml:2: predicates.histogram.entry: expected text, found nothing"}));
  std::ofstream(path) << "[predicates]\nlabels = \"a.mha\"\n";
  EXPECT_TRUE(test::rejects(read_session_config(path), ErrorCode::kMalformedData,
                            {"predicates.labels", "a list of texts"}));
}

}  // namespace
}  // namespace nav::app
