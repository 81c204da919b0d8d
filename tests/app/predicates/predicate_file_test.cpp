// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_file.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "render/predicates/registry.hpp"
#include "tests/support/matchers.hpp"

namespace nav::app {
namespace {

using render::PredicateExpression;

class PredicateFileTest : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }
  Result<PredicateFile> read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_predicate_file(path_);
  }
  ::testing::AssertionResult rejects(const std::string& text,
                                     std::initializer_list<std::string> pieces,
                                     ErrorCode code = ErrorCode::kMalformedData) {
    return test::rejects(read(text), code, pieces);
  }
  std::filesystem::path path_ = std::filesystem::temp_directory_path() /
                                ("sonde_predicates_" + std::to_string(getpid()) + ".json");
};

TEST_F(PredicateFileTest, PresetsSurviveARoundTripThroughAFile) {
  for (const std::string& name : render::predicate_preset_names()) {
    PredicateFile file{name, *render::preset_predicates(name)};
    file.opacity_length_mm = 1.25;
    file.cutaway_importance = 0.75;
    file.hue_mean = render::spec::HueMean::kLinear;
    file.vessels = {1.5, 2.5, true};
    file.smoothing_mm = 1.75;
    file.snr = {9, render::features::WindowWeights::kGaussian};
    file.confidence.alpha = 1;
    file.confidence.beta = 45;
    file.confidence.gamma = 0.25;
    const auto back = read(to_json_text(file));
    ASSERT_TRUE(test::has_value(back)) << name;
    EXPECT_EQ(back->name, name);
    EXPECT_EQ(back->opacity_length_mm, 1.25);
    EXPECT_EQ(back->cutaway_importance, 0.75);
    EXPECT_EQ(back->vessels.smallest_radius_mm, 1.5);
    EXPECT_EQ(back->vessels.largest_radius_mm, 2.5);
    EXPECT_TRUE(back->vessels.bright);
    EXPECT_EQ(back->hue_mean, render::spec::HueMean::kLinear);
    EXPECT_EQ(back->smoothing_mm, 1.75);
    EXPECT_EQ(back->snr.window_voxels, 9);
    EXPECT_EQ(back->snr.weights, render::features::WindowWeights::kGaussian);
    EXPECT_EQ(back->confidence.alpha, 1);
    EXPECT_EQ(back->confidence.beta, 45);
    EXPECT_EQ(back->confidence.gamma, 0.25);
    ASSERT_EQ(back->model.entries.size(), file.model.entries.size());
    for (std::size_t j = 0; j < file.model.entries.size(); ++j) {
      EXPECT_EQ(back->model.entries[j].name, file.model.entries[j].name);
      EXPECT_EQ(back->model.entries[j].expression.op, file.model.entries[j].expression.op);
      EXPECT_NEAR(back->model.histogram.bars()[j].importance,
                  file.model.histogram.bars()[j].importance, 1e-15);
    }
    // After one round trip the text does not change any more.
    EXPECT_EQ(to_json_text(*back), to_json_text(file));
  }
}

TEST_F(PredicateFileTest, ShadingSurvivesARoundTripAndIsOffByDefault) {
  const std::string entry = R"("predicates": [{"name": "a", "where": {"snr": {}}}]})";
  const auto plain = read(R"({"sonde_predicates": 1, )" + entry);
  ASSERT_TRUE(test::has_value(plain));
  EXPECT_EQ(plain->shading_mm, 0);
  EXPECT_EQ(to_json_text(*plain).find("shading"), std::string::npos);
  const auto file = read(
      R"({"sonde_predicates": 1, "shading": {"smoothing_mm": 1.5, "full_gradient_per_mm": 0.2}, )" +
      entry);
  ASSERT_TRUE(test::has_value(file));
  const auto back = read(to_json_text(*file));
  ASSERT_TRUE(test::has_value(back));
  EXPECT_EQ(back->shading_mm, 1.5);
  EXPECT_EQ(back->full_gradient_per_mm, 0.2);
  EXPECT_TRUE(rejects(R"({"sonde_predicates": 1, "shading": {"smoothing_mm": 21}, )" + entry,
                      {"shading.smoothing_mm", "[0, 20]", "21"}));
  EXPECT_TRUE(rejects(R"({"sonde_predicates": 1, "shading": {"full_gradient_per_mm": 0}, )" + entry,
                      {"shading.full_gradient_per_mm", "[0.0001, 100]"}));
}

TEST_F(PredicateFileTest, ConnectedPartsFloorsAndSoftThresholdsSurviveARoundTrip) {
  const auto file = read(R"({"sonde_predicates": 1, "soft_thresholds": 0.25, "predicates": [
      {"name": "vessel", "floor": 0.3, "where": {"connected": {"least_mm3": 40,
        "of": {"all": [{"vesselness": {"low": 0.2}}, {"not": {"entry": "rest"}}]}}}},
      {"name": "rest", "where": {"intensity": {"low": 0.5}}}]})");
  ASSERT_TRUE(test::has_value(file));
  EXPECT_EQ(file->soft_share, 0.25);
  EXPECT_EQ(file->model.entries[0].floor, 0.3);
  EXPECT_EQ(file->model.entries[0].expression.op,
            render::PredicateExpression::Operator::kConnected);
  const auto back = read(to_json_text(*file));
  ASSERT_TRUE(test::has_value(back));
  EXPECT_EQ(back->model, file->model);
  EXPECT_EQ(back->soft_share, 0.25);
  const auto with = [](const std::string& part) {
    return R"({"sonde_predicates": 1, "predicates": [{"name": "a", )" + part + "}]}";
  };
  EXPECT_TRUE(rejects(with(R"("where": {"connected": {"least_mm3": -1, "of": {"snr": {}}}})"),
                      {"connected.least_mm3", "[0, 1e9]"}));
  EXPECT_TRUE(rejects(with(R"("where": {"connected": {"least_mm3": 1}})"),
                      {"connected", "of", "an expression"}));
  EXPECT_TRUE(rejects(with(R"("floor": 2, "where": {"snr": {}})"), {"a: floor", "[0, 1]", "2"}));
  EXPECT_TRUE(rejects(R"({"sonde_predicates": 1, "soft_thresholds": 3,
                          "predicates": [{"name": "a", "where": {"snr": {}}}]})",
                      {"soft_thresholds", "[0, 1]", "3"}));
}

TEST_F(PredicateFileTest, IntensityHasNoUpperLimitByDefault) {
  const auto file = read(R"({"sonde_predicates": 1, "predicates": [{"name": "a",
      "where": {"intensity": {"low": 0.2}}}]})");
  ASSERT_TRUE(test::has_value(file));
  EXPECT_GE(file->model.entries[0].expression.values[1], 1e6);
}

// Users need the initial values, because files may omit parameters.
TEST(PredicateLibraryTest, TheDocumentationListsTheInitialValues) {
  std::ifstream page(std::string(SONDE_SOURCE_DIR) + "/docs/predicates.md");
  const std::string text{std::istreambuf_iterator<char>(page), {}};
  for (const render::PredicateKind* kind : render::predicate_kinds()) {
    const std::string name = kind->name();
    const auto row = text.find("| `" + name + "` |");
    ASSERT_NE(row, std::string::npos) << name;
    const std::string line = text.substr(row, text.find('\n', row) - row);
    for (const auto& p : kind->parameters()) {
      const bool radians = p.name.ends_with("_rad");
      const std::string key = radians ? p.name.substr(0, p.name.size() - 4) + "_deg" : p.name;
      char value[32];
      std::snprintf(value, sizeof value, "%.3g", radians ? p.initial * 180 / M_PI : p.initial);
      EXPECT_NE(line.find("`" + key + "` " + value), std::string::npos)
          << name << ' ' << key << ' ' << value;
    }
  }
}

TEST_F(PredicateFileTest, TheDeepestCombinationsSurviveARoundTrip) {
  const auto nested = [](int depth, auto combine) {
    auto expression = PredicateExpression::kind("snr", {1, 2});
    for (int n = 0; n < depth; ++n) expression = combine(std::move(expression));
    render::PredicateModel model;
    model.entries.push_back({"deep", std::move(expression)});
    model.histogram = *render::PredicateHistogram::create({{1, 0, 0}});
    return PredicateFile{"deep", std::move(model)};
  };
  const auto all = [](PredicateExpression e) { return PredicateExpression::all({std::move(e)}); };
  const auto any = [](PredicateExpression e) { return PredicateExpression::any({std::move(e)}); };
  const auto no = [](PredicateExpression e) { return PredicateExpression::negation(std::move(e)); };
  const auto check = [&](auto combine) {
    for (int depth = 13; depth <= 16; ++depth) {
      const auto file = nested(depth, combine);
      ASSERT_TRUE(test::has_value(render::validate(file.model))) << depth;
      const auto back = read(to_json_text(file));
      ASSERT_TRUE(test::has_value(back)) << depth;
      EXPECT_TRUE(back->model == file.model) << depth;
    }
    EXPECT_TRUE(
        rejects(to_json_text(nested(17, combine)), {path_.string(), "deep: ", "at most 16 deep"}));
  };
  check(all);
  check(any);
  check(no);
}

TEST_F(PredicateFileTest, AnglesAreDegreesInTheFile) {
  const auto file = read(R"({"sonde_predicates": 1, "predicates": [{"name": "a", "importance": 3,
      "where": {"gradient_angle": {"high_deg": 45}}}]})");
  ASSERT_TRUE(test::has_value(file));
  const PredicateExpression& e = file->model.entries[0].expression;
  EXPECT_EQ(e.name, "gradient_angle");
  EXPECT_EQ(e.values[0], 0);
  EXPECT_NEAR(e.values[1], M_PI / 4, 1e-15);
  EXPECT_EQ(file->model.histogram.bars()[0].importance, 1) << "scaled to sum 1";
}

TEST_F(PredicateFileTest, ANewerVersionIsRejectedWithOneSentence) {
  EXPECT_TRUE(rejects(R"({"sonde_predicates": 2, "somethings": []})",
                      {"expected version 1", "found 2", "newer"}, ErrorCode::kUnsupportedData));
}

TEST_F(PredicateFileTest, ErrorsNameThePositionInTheFile) {
  const auto with = [](const std::string& where) {
    return R"({"sonde_predicates": 1, "predicates": [{"name": "a", "where": )" + where + "}]}";
  };
  EXPECT_TRUE(rejects("[1, 2]", {"an object"}));
  EXPECT_TRUE(rejects("{\"sonde_predicates\": 1", {"expected JSON"}));
  EXPECT_TRUE(rejects(R"({"predicates": []})", {"sonde_predicates"}));
  EXPECT_TRUE(rejects(R"({"sonde_predicates": 1})", {"1 to 32", "found 0"}));
  EXPECT_TRUE(rejects(with(R"({"sharpness": {}})"), {"predicates[0].where", "sharpness"},
                      ErrorCode::kNotFound));
  EXPECT_TRUE(rejects(with(R"({"snr": {"low": "x"}})"), {"where.snr.low", "a number"}));
  EXPECT_TRUE(rejects(with(R"({"snr": {"lowest": 1}})"), {"where.snr.lowest", "no such member"}));
  EXPECT_TRUE(rejects(with(R"({"snr": {"low": 2, "high": 1}})"), {"low <= high"}));
  EXPECT_TRUE(rejects(with(R"({"all": [{"not": {}}]})"), {"where.all[0].not", "one of"}));
  EXPECT_TRUE(rejects(R"({"sonde_predicates": 1, "vessels": {"largest_radius_mm": 0.1}})",
                      {"vessels.largest_radius_mm", "at least", "0.1"}));
  EXPECT_TRUE(rejects(with(R"({"entry": "a"})"), {"cycle"}));
  EXPECT_TRUE(rejects(with(R"({"gradient_angle": {"high_deg": 400}})"),
                      {"gradient_angle.high_deg: expected a number in [0, 180], found 400"}));
  EXPECT_TRUE(rejects(with(R"({"gradient_angle": {"low_deg": 50, "high_deg": 20}})"),
                      {"gradient_angle: expected low_deg <= high_deg, found 50 and 20"}));
  EXPECT_TRUE(rejects(R"({"sonde_predicates": 1, "predicates": [
                          {"name": "a", "importance": 0, "where": {"snr": {}}},
                          {"name": "b", "importance": 0, "where": {"snr": {}}}]})",
                      {"an importance above 0, found 0"}));
  EXPECT_TRUE(rejects(with(R"({"label": {"mask": 4294967296}})"),
                      {"label.mask", "[1, 4294967295]", "found 4294967296"}));
  EXPECT_TRUE(rejects(with(R"({"snr": {"low": 1e300}})"), {"snr.low", "[-1000000, 1000]"}));
  const auto also = [](const std::string& member) {
    return R"({"sonde_predicates": 1, "predicates": [{"name": "a", "where": {"snr": {}}}], )" +
           member + "}";
  };
  const std::string file = path_.string();
  EXPECT_TRUE(rejects(also(R"("cutaway_importance": 2)"), {file, "cutaway_importance", "[0, 1]"}));
  for (const char* length : {"0", "-3", "1e300"}) {
    EXPECT_TRUE(rejects(also(R"("opacity_length_mm": )" + std::string(length)),
                        {file, "opacity_length_mm", "[0.001, 10000]"}));
  }
  EXPECT_TRUE(rejects(also(R"("gradient": {"smoothing_mm": -1})"),
                      {file, "gradient.smoothing_mm", "[0, 20]"}));
  EXPECT_TRUE(rejects(also(R"("snr": {"window_voxels": 4})"),
                      {file, "snr.window_voxels", "odd", "found 4"}));
  EXPECT_TRUE(rejects(also(R"("snr": {"weights": "flat"})"), {"snr.weights", "gaussian", "flat"}));
  EXPECT_TRUE(rejects(also(R"("confidence": {"alpha": 200})"), {file, "alpha in [0, 20]", "200"}));
  EXPECT_TRUE(rejects(also(R"("confidence": {"delta": 2})"), {"confidence.delta", "no such"}));
  EXPECT_TRUE(rejects(also(R"("vessels": {"largest_radius_mm": 1000})"),
                      {file, "vessels.largest_radius_mm", "at most 100"}));
  EXPECT_TRUE(rejects(also(R"("name": "b", "name": "c")"), {file, "once", "\"name\" twice"}));
  EXPECT_TRUE(rejects(R"({"sonde_predicates": 1, "predicates": [{"name": "a", "importance": 1e300,
                          "where": {"snr": {}}}]})",
                      {file, "an importance >= 0, at most 1e100, found 1e+300"}));
  const auto broken = read("{\"sonde_predicates\": 1");
  ASSERT_FALSE(broken.has_value());
  EXPECT_EQ(broken.error().message.find("exception"), std::string::npos) << broken.error().message;
  std::string many;
  for (int n = 0; n < 33; ++n) {
    many += (n > 0 ? ", " : "") + (R"({"snr": {"low": )" + std::to_string(n) + "}}");
  }
  EXPECT_TRUE(rejects(with(R"({"any": [)" + many + "]}"), {file, "at most 32", "found 33"}));
  std::string entries;
  for (int n = 0; n < 64; ++n) {
    entries += (n > 0 ? ", " : "") + (R"({"name": "p)" + std::to_string(n)) +
               R"(", "importance": 1, "where": {"snr": {}}})";
  }
  EXPECT_TRUE(rejects(R"({"sonde_predicates": 1, "predicates": [)" + entries + "]}",
                      {file, "at most 32", "found 64"}));
  EXPECT_TRUE(rejects(with("7"), {"where", "an object"}));
  EXPECT_TRUE(test::rejects(read_predicate_file("/nowhere/x.json"), ErrorCode::kNotFound,
                            {"/nowhere/x.json"}));
}

}  // namespace
}  // namespace nav::app
