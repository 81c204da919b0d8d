// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/transfer_presets.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

std::shared_ptr<const StoredVolume> head_like(double scale) {
  // Background near 0, tissue near 400, bright values 1000, times a scale.
  return test::make_volume(test::centred_grid({40, 40, 40}, {1, 1, 1}), [=](int i, int j, int k) {
    const double r = std::hypot(i - 20, j - 20, k - 20);
    const double noise = (i * 7 + j * 13 + k * 29) % 11;
    return scale * (r > 17 ? noise : (r > 8 ? 400 + 5 * noise : 1000 + noise));
  });
}

TEST(PresetTest, EachNameGivesAFunctionWithOrderedImportance) {
  const auto ct = head_like(1);
  EXPECT_EQ(preset_names().size(), 6U);
  for (const std::string& name : preset_names()) {
    const auto f = preset_for(name, *ct);
    ASSERT_TRUE(test::has_value(f));
    EXPECT_EQ(f->name(), name);
    double greatest = 0;
    for (const auto& component : f->components()) {
      for (const auto& node : component.nodes) greatest = std::max(greatest, node.importance);
    }
    // In MR the brightest tissue may be fat, which must not bury the plane.
    EXPECT_GE(greatest, name == "mr-default" ? 0.5 : 0.99)
        << name << ": something stays in front of the plane";
  }
  EXPECT_TRUE(test::rejects(preset_for("x-ray", *ct), ErrorCode::kNotFound, {"x-ray", "ct-liver"}));
}

TEST(PresetTest, CtAppearancesRankTissuesAsInThePaper) {
  const auto importance = [](const char* name, double hu) {
    return preset_transfer_function(name)->at(hu).importance;
  };
  for (const char* name : {"ct-liver", "ct-soft-tissue"}) {
    EXPECT_LE(importance(name, -100), 0.1) << "fat";
    EXPECT_LE(importance(name, 50), 0.1) << "muscle";
    EXPECT_GE(importance(name, 1000), 0.99) << "bone";
  }
  EXPECT_EQ(importance("ct-liver", 115), 0.5) << "enhanced liver";
  EXPECT_EQ(importance("ct-liver", 220), 1) << "its vessels";
  EXPECT_EQ(importance("cta-vessels", 330), 1);
  EXPECT_LT(importance("cta-vessels", 60), 0.2);
}

TEST(ValueRangeTest, LeavesOutBackgroundAndOutliers) {
  const ValueRange range = value_range(*head_like(1));
  EXPECT_GE(range.low, 0);
  EXPECT_LT(range.low, 400);
  EXPECT_NEAR(range.high, 1009, 10);
  const auto flat =
      test::make_volume(test::centred_grid({4, 4, 4}, {1, 1, 1}), [](int, int, int) { return 7; });
  EXPECT_GT(value_range(*flat).high, value_range(*flat).low);
}

TEST(ValueRangeTest, EndsBelowTheBrightestHalfPercentOfTheForeground) {
  // 1000 voxels of background, then 1001, 1002, ... 2000.
  const auto volume =
      test::make_volume(test::centred_grid({10, 10, 20}, {1, 1, 1}), [](int i, int j, int k) {
        const int n = (k * 10 + j) * 10 + i;
        return n < 1000 ? 0 : n + 1;
      });
  EXPECT_EQ(value_range(*volume).low, 0);
  EXPECT_EQ(value_range(*volume).high, 1995);
}

TEST(PresetTest, MrIsFittedToTheValuesOfTheVolume) {
  const auto one = preset_for("mr-default", *head_like(1));
  const auto ten = preset_for("mr-default", *head_like(10));
  ASSERT_TRUE(test::has_value(one) && test::has_value(ten));
  EXPECT_EQ(one->at(5).tau_per_mm, 0) << "background";
  EXPECT_EQ(ten->at(50).tau_per_mm, 0);
  EXPECT_LE(one->at(1005).importance, 0.1) << "fat does not bury the plane";
  // Tissue has the same appearance for each scale of the scanner.
  EXPECT_NEAR(ten->at(4250).tau_per_mm / one->at(425).tau_per_mm, 1, 0.15);
  EXPECT_NEAR((ten->at(4250).rgb - one->at(425).rgb).norm(), 0, 0.05);
}

TEST(RescaledTest, MapsValuesAndGradientWindows) {
  TransferComponent c{"edge", {{0, {1, 0, 0}, 0.1, 0.3}, {10, {0, 1, 0}, 0.5, 0.6}}, {}};
  c.gradient = GradientWindow{1, 2, 3, 4};
  const auto f = *TransferFunction::blend("f", {c});
  const auto g = *rescaled(f, {0, 10}, {100, 300});
  for (const double share : {0.0, 0.3, 1.0}) {
    const auto a = f.at(10 * share, 1.5);
    const auto b = g.at(100 + 200 * share, 30);
    EXPECT_NEAR(a.tau_per_mm, b.tau_per_mm, 1e-12);
    EXPECT_NEAR((a.rgb - b.rgb).norm(), 0, 1e-12);
  }
  EXPECT_TRUE(same_classification(f, *rescaled(f, {0, 10}, {0, 10})));
  Shading shading;
  shading.full_gradient_per_mm = 10;
  EXPECT_EQ(rescaled(shading, {0, 10}, {100, 300}).full_gradient_per_mm, 200);
}

TEST(RescaledTest, RejectsValuesThatBecomeEqualOrExceedTheNumberRange) {
  const auto near = *TransferFunction::create(
      "near", {{0, {1, 0, 0}, 0.1, 0.3}, {std::nextafter(0.0, 1.0), {0, 1, 0}, 0.5, 0.6}});
  EXPECT_TRUE(test::rejects(rescaled(near, {0, 10}, {100, 300}), ErrorCode::kMalformedData,
                            {"near", "node 1"}));
  const auto far = *TransferFunction::create(
      "far", {{-1e308, {1, 0, 0}, 0.1, 0.3}, {1e308, {0, 1, 0}, 0.5, 0.6}});
  EXPECT_TRUE(test::rejects(rescaled(far, {0, 1}, {100, 300}), ErrorCode::kMalformedData,
                            {"far", "finite"}));
}

TEST(WithImportanceTest, SetsImportanceInARangeAndChangesNothingElse) {
  const auto f = *TransferFunction::create(
      "f", {{0, {1, 0, 0}, 0.0, 0.2}, {100, {0, 1, 0}, 0.5, 0.4}, {300, {0, 0, 1}, 0.9, 0.6}});
  const auto g = with_importance(f, {{150, 250, 1.0}});
  ASSERT_TRUE(test::has_value(g));
  for (double hu = -50; hu < 400; hu += 0.25) {
    EXPECT_NEAR(g->at(hu).tau_per_mm, f.at(hu).tau_per_mm, 1e-12) << hu;
    EXPECT_NEAR((g->at(hu).rgb - f.at(hu).rgb).norm(), 0, 1e-12) << hu;
    const bool within = hu >= 150 && hu <= 250;
    const bool jump = !within && hu > 149.5 && hu < 250.5;
    const double expected = within ? 1 : f.at(hu).importance;
    EXPECT_TRUE(jump || std::abs(g->at(hu).importance - expected) < 1e-12) << hu;
  }
}

TEST(WithImportanceTest, RulesApplyInOrderAndByComponent) {
  const TransferComponent a{"a", {{0, {1, 0, 0}, 0.5, 0.1}, {100, {1, 0, 0}, 0.5, 0.1}}, {}};
  TransferComponent b = a;
  b.name = "b";
  const auto f = *TransferFunction::blend("f", {a, b});
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto g = with_importance(f, {{-kInfinity, kInfinity, 0.25}, {40, 60, 0.75, "b"}});
  ASSERT_TRUE(test::has_value(g));
  EXPECT_EQ(g->components()[0].nodes.size(), 2U) << "an endless range needs no nodes";
  EXPECT_EQ(g->at(50).importance, 0.75);
  EXPECT_EQ(g->at(20).importance, 0.25);
}

TEST(WithImportanceTest, RejectsInvalidRules) {
  const auto f = *preset_transfer_function("ct-bone");
  const auto refused = [&](const ImportanceRule& rule, const std::string& piece) {
    return test::rejects(with_importance(f, {rule}), ErrorCode::kUsage, {"importance of", piece});
  };
  EXPECT_TRUE(refused({100, 50, 0.5}, "range"));
  EXPECT_TRUE(refused({std::nan(""), 50, 0.5}, "range"));
  EXPECT_TRUE(refused({0, 50, 1.5}, "[0, 1]"));
  EXPECT_TRUE(refused({0, 50, std::nan("")}, "[0, 1]"));
  EXPECT_TRUE(refused({0, 50, 0.5, "liver"}, "one of the components bone"));
}

}  // namespace
}  // namespace nav::render
