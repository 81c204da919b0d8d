// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/transfer_function.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

constexpr double kTauRounding = 1e-12;

std::vector<TransferNode> ramp() {
  return {{0, {0, 0.5, 1}, 0.0, 0.0}, {100, {1, 0.5, 0}, 0.5, 1.0}};
}

TEST(TransferFunctionTest, ExtinctionIsLinearInHuAndOpacityIsPerMillimetre) {
  const auto f = TransferFunction::create("ramp", ramp());
  ASSERT_TRUE(test::has_value(f));
  const TransferSample end = f->at(100);
  EXPECT_NEAR(-std::expm1(-end.tau_per_mm), 0.5, kTauRounding);
  const TransferSample quarter = f->at(25);
  EXPECT_NEAR(quarter.tau_per_mm, 0.25 * std::log(2.0), kTauRounding);
  EXPECT_NEAR(quarter.rgb.x(), 0.25, kTauRounding);
  EXPECT_NEAR(quarter.rgb.z(), 0.75, kTauRounding);
  EXPECT_NEAR(quarter.importance, 0.25, kTauRounding);
}

TEST(TransferFunctionTest, EndValuesHoldOutside) {
  const auto f = TransferFunction::create("ramp", ramp());
  ASSERT_TRUE(test::has_value(f));
  EXPECT_EQ(f->at(-5000).tau_per_mm, 0);
  EXPECT_EQ(f->at(-5000).rgb, Eigen::Vector3d(0, 0.5, 1));
  EXPECT_EQ(f->at(5000).tau_per_mm, f->at(100).tau_per_mm);
  EXPECT_EQ(f->at(5000).rgb, Eigen::Vector3d(1, 0.5, 0));
}

TEST(TransferFunctionTest, KeepsTinyOpacitiesExact) {
  const auto f =
      TransferFunction::create("thin", {{0, {1, 1, 1}, 1e-15, 0}, {1, {1, 1, 1}, 1e-15, 0}});
  ASSERT_TRUE(test::has_value(f));
  EXPECT_NEAR(f->at(0).tau_per_mm / 1e-15, 1.0, kTauRounding);
}

TEST(TransferFunctionTest, NamesTheInvalidNode) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with = [](auto change) {
    auto nodes = ramp();
    change(nodes[1]);
    return TransferFunction::create("bad", nodes);
  };
  const auto refused = [](const auto& f, std::initializer_list<std::string> pieces) {
    return test::rejects(f, ErrorCode::kMalformedData, pieces);
  };
  EXPECT_TRUE(refused(TransferFunction::create("bad", {ramp()[0]}), {"bad", "two nodes", "1"}));
  EXPECT_TRUE(refused(with([](auto& n) { n.hu = 0; }), {"node 1", "more than the 0 HU"}));
  EXPECT_TRUE(refused(with([&](auto& n) { n.hu = nan; }), {"node 1", "finite"}));
  EXPECT_TRUE(refused(with([](auto& n) { n.rgb.y() = 1.5; }), {"node 1", "colours", "1.5"}));
  EXPECT_TRUE(refused(with([](auto& n) { n.opacity = 1; }), {"node 1", "opacity"}));
  EXPECT_TRUE(refused(with([&](auto& n) { n.opacity = nan; }), {"node 1", "opacity"}));
  EXPECT_TRUE(refused(with([](auto& n) { n.importance = -0.1; }), {"node 1", "importance"}));
}

constexpr double kNoEnd = std::numeric_limits<double>::infinity();

double opacity_of(const TransferSample& sample) { return -std::expm1(-sample.tau_per_mm); }

/// A component with the same appearance for all values.
TransferComponent even(const std::string& name, const Eigen::Vector3d& rgb, double opacity,
                       double importance) {
  return {name, {{-10, rgb, opacity, importance}, {10, rgb, opacity, importance}}, {}};
}

TransferFunction blended(std::vector<TransferComponent> components) {
  auto f = TransferFunction::blend("blend", std::move(components));
  EXPECT_TRUE(test::has_value(f));
  return *std::move(f);
}

TEST(TransferFunctionBlendTest, WeightsColoursByOpacityTimesImportance) {
  const auto f = blended({even("a", {1, 0, 0}, 0.2, 0.25), even("b", {0, 1, 0}, 0.1, 1.0),
                          even("c", {0, 0, 1}, 0.4, 0.5)});
  // Weights 0.05, 0.1 and 0.2 of 0.35.
  const TransferSample s = f.at(0);
  EXPECT_NEAR(s.rgb.x(), 1.0 / 7, kTauRounding);
  EXPECT_NEAR(s.rgb.y(), 2.0 / 7, kTauRounding);
  EXPECT_NEAR(s.rgb.z(), 4.0 / 7, kTauRounding);
  EXPECT_NEAR(opacity_of(s), 0.4, kTauRounding);
  EXPECT_EQ(s.importance, 1);
}

TEST(TransferFunctionBlendTest, TheOrderOfComponentsDoesNotMatter) {
  const auto a = even("a", {1, 0.3, 0}, 0.2, 0.25);
  const auto b = even("b", {0, 1, 0.7}, 0.1, 0.9);
  const TransferSample one = blended({a, b}).at(0);
  const TransferSample other = blended({b, a}).at(0);
  EXPECT_NEAR((one.rgb - other.rgb).norm(), 0, kTauRounding);
  EXPECT_EQ(one.tau_per_mm, other.tau_per_mm);
  EXPECT_EQ(one.importance, other.importance);
}

TEST(TransferFunctionBlendTest, AllImportancesZeroIsTheLimitOfEqualSmallOnes) {
  const auto at = [](double importance) {
    return blended({even("a", {1, 0, 0}, 0.3, importance), even("b", {0, 1, 0}, 0.1, importance)})
        .at(0);
  };
  const TransferSample zero = at(0);
  EXPECT_NEAR(zero.rgb.x(), 0.75, kTauRounding);
  EXPECT_NEAR(zero.rgb.y(), 0.25, kTauRounding);
  EXPECT_EQ(zero.importance, 0);
  EXPECT_NEAR((at(1e-300).rgb - zero.rgb).norm(), 0, kTauRounding);
}

TEST(TransferFunctionBlendTest, AnInvisibleComponentHasNoEffect) {
  const TransferSample s =
      blended({even("clear", {1, 0, 0}, 0, 1), even("seen", {0, 1, 0}, 1e-9, 0.2)}).at(0);
  EXPECT_EQ(s.rgb, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(s.importance, 0.2);
}

/// Visible in (low, high), zero at both ends.
TransferComponent peak(const Eigen::Vector3d& rgb, double low, double high, double importance) {
  return {"peak",
          {{low, rgb, 0, importance},
           {0.5 * (low + high), rgb, 0.5, importance},
           {high, rgb, 0, importance}},
          {}};
}

TEST(TransferFunctionBlendTest, InvisibleValuesTakeTheColourOfTheNearestVisibleRange) {
  const Eigen::Vector3d red(1, 0, 0);
  const Eigen::Vector3d blue(0, 0, 1);
  const auto f = blended({peak(red, 0, 100, 1), peak(blue, 200, 300, 0.5)});
  for (const double hu : {-50.0, 0.0, 100.0, 149.0}) EXPECT_EQ(f.at(hu).rgb, red) << hu;
  for (const double hu : {151.0, 200.0, 300.0, 999.0}) EXPECT_EQ(f.at(hu).rgb, blue) << hu;
  for (const double hu : {-50.0, 0.0, 149.0, 151.0, 999.0}) {
    EXPECT_EQ(f.at(hu).tau_per_mm, 0) << hu;
    EXPECT_EQ(f.at(hu).importance, 0) << hu;
  }
}

TEST(TransferFunctionBlendTest, AComponentHiddenByItsWindowStillGivesItsColour) {
  TransferComponent edge = even("edge", {1, 0, 0}, 0.5, 1);
  edge.gradient = GradientWindow{50, 50, kNoEnd, kNoEnd};
  const auto f = blended({peak({0, 0, 1}, 20, 40, 1), edge});
  EXPECT_EQ(f.at(0, 0).rgb, Eigen::Vector3d(1, 0, 0)) << "inside the range of the hidden one";
  EXPECT_EQ(f.at(0, 0).tau_per_mm, 0);
}

TEST(TransferFunctionBlendTest, AFunctionThatIsNowhereVisibleStillHasAColour) {
  const TransferSample s = blended({even("clear", {0.2, 0.4, 0.6}, 0, 1)}).at(3);
  EXPECT_EQ(s.rgb, Eigen::Vector3d(0.2, 0.4, 0.6));
  EXPECT_EQ(s.tau_per_mm, 0);
  EXPECT_EQ(s.importance, 0);
}

TEST(TransferFunctionBlendTest, AlmostFullImportanceIsFull) {
  const auto importance = [](double i) {
    return blended({even("a", {1, 1, 1}, 0.5, i)}).at(0).importance;
  };
  EXPECT_EQ(importance(1 - 1.0 / 4096), 1);
  EXPECT_EQ(importance(1 - 1.0 / 16777216), 1);
  EXPECT_LT(importance(std::nextafter(1 - 1.0 / 4096, 0)), 1);
  EXPECT_EQ(importance(0.5), 0.5);
}

TEST(TransferFunctionBlendTest, GradientWindowIsATrapezoidOnTheExtinction) {
  TransferComponent c = even("edge", {1, 1, 1}, 0.5, 1);
  const double full = -std::log1p(-0.5);
  const auto share = [&](const GradientWindow& w, double gradient) {
    c.gradient = w;
    const auto f = blended({c});
    EXPECT_TRUE(f.uses_gradient());
    return f.at(0, gradient).tau_per_mm / full;
  };
  const GradientWindow trapezoid{10, 20, 40, 80};
  const std::vector<std::pair<double, double>> expected{
      {0, 0}, {10, 0}, {15, 0.5}, {20, 1}, {30, 1}, {40, 1}, {60, 0.5}, {80, 0}, {1e9, 0}};
  for (const auto& [gradient, weight] : expected) {
    EXPECT_NEAR(share(trapezoid, gradient), weight, kTauRounding) << gradient;
  }
  const GradientWindow open{10, 20, kNoEnd, kNoEnd};
  EXPECT_EQ(share(open, 1e30), 1);
  EXPECT_EQ(share(open, kNoEnd), 1);
  const GradientWindow box{10, 10, 20, 20};
  EXPECT_EQ(share(box, 9.999), 0);
  EXPECT_EQ(share(box, 10), 1);
  EXPECT_EQ(share(box, 20), 1);
  EXPECT_EQ(share(box, 20.001), 0);
  EXPECT_EQ(share({0, 0, kNoEnd, kNoEnd}, 0), 1) << "a window over everything";
}

TEST(TransferFunctionBlendTest, RejectsInvalidComponents) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const std::vector<TransferComponent>& components,
                          std::initializer_list<std::string> pieces) {
    return test::rejects(TransferFunction::blend("look", components), ErrorCode::kMalformedData,
                         pieces);
  };
  EXPECT_TRUE(refused({}, {"look", "at least one component"}));
  const auto good = even("good", {1, 1, 1}, 0.5, 1);
  const auto with = [&](auto change) {
    TransferComponent bad = good;
    bad.name = "bad";
    change(bad);
    return std::vector<TransferComponent>{good, bad};
  };
  EXPECT_TRUE(refused(with([](auto& c) { c.nodes.clear(); }), {"component bad", "found 0"}));
  EXPECT_TRUE(refused(with([](auto& c) { std::swap(c.nodes[0], c.nodes[1]); }),
                      {"component bad", "node 1", "more than the 10 HU", "-10"}));
  EXPECT_TRUE(refused(with([](auto& c) { c.nodes[1].hu = -10; }), {"node 1", "more than the -10"}));
  EXPECT_TRUE(refused(with([&](auto& c) { c.nodes[0].hu = nan; }), {"node 0", "finite"}));
  EXPECT_TRUE(refused(with([&](auto& c) { c.nodes[0].hu = -kNoEnd; }), {"node 0", "finite"}));
  EXPECT_TRUE(refused(with([](auto& c) { c.nodes[0].importance = 1.5; }),
                      {"component bad", "node 0", "importance in [0, 1]", "1.5"}));
  EXPECT_TRUE(refused(with([&](auto& c) { c.nodes[0].importance = nan; }), {"importance"}));
  EXPECT_TRUE(refused(with([&](auto& c) { c.nodes[0].rgb.z() = nan; }), {"colours in [0, 1]"}));
  const auto window = [&](double a, double b, double c, double d) {
    return with([=](TransferComponent& one) { one.gradient = GradientWindow{a, b, c, d}; });
  };
  EXPECT_TRUE(refused(window(-1, 0, 1, 2), {"component bad", "gradient window", "-1"}));
  EXPECT_TRUE(refused(window(2, 1, 3, 4), {"gradient window"}));
  EXPECT_TRUE(refused(window(0, 1, 3, 2), {"gradient window"}));
  EXPECT_TRUE(refused(window(0, nan, 3, 4), {"gradient window"}));
  EXPECT_TRUE(refused(window(0, 1, 2, kNoEnd), {"gradient window", "both infinite", "inf"}));
  EXPECT_TRUE(refused(window(kNoEnd, kNoEnd, kNoEnd, kNoEnd), {"gradient window"}));
}

TEST(TransferFunctionBlendTest, RandomBlendsStayInRange) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<TransferComponent> components;
    for (int c = 0; c < 1 + trial % 6; ++c) {
      const double low = 200 * unit(random) - 100;
      components.push_back(peak({unit(random), unit(random), unit(random)}, low,
                                low + 1e-3 + 100 * unit(random), unit(random)));
    }
    const auto f = blended(components);
    for (double hu = -150; hu < 250; hu += 3.7) {
      const TransferSample s = f.at(hu);
      EXPECT_TRUE(s.rgb.allFinite() && s.rgb.minCoeff() >= 0 && s.rgb.maxCoeff() <= 1) << hu;
      EXPECT_TRUE(s.tau_per_mm >= 0 && s.importance >= 0 && s.importance <= 1) << hu;
    }
  }
}

TEST(PresetTransferFunctionTest, ShowsTheTissueThatItsNameStates) {
  const auto bone = preset_transfer_function("ct-bone");
  const auto soft = preset_transfer_function("ct-soft-tissue");
  const auto vessels = preset_transfer_function("cta-vessels");
  ASSERT_TRUE(test::has_value(bone));
  ASSERT_TRUE(test::has_value(soft));
  ASSERT_TRUE(test::has_value(vessels));
  for (const auto* f : {&*bone, &*soft, &*vessels}) {
    EXPECT_EQ(f->at(-1024).tau_per_mm, 0) << f->name() << ": air is invisible";
  }
  EXPECT_EQ(bone->at(60).tau_per_mm, 0) << "no soft tissue among bone";
  EXPECT_GT(bone->at(900).tau_per_mm, 2) << "cortex is opaque within a millimetre";
  // A plane below 100 mm of liver keeps a third of its light.
  EXPECT_GT(std::exp(-100 * soft->at(110).tau_per_mm), 0.33);
  EXPECT_GT(soft->at(110).tau_per_mm, 0);
  const TransferSample artery = vessels->at(330);
  EXPECT_GT(artery.rgb.x(), 4 * artery.rgb.y()) << "contrast is red";
  EXPECT_GT(artery.tau_per_mm * 3, 0.7) << "a vessel of 3 mm shows";
  EXPECT_GT(vessels->at(900).rgb.y(), 0.8) << "bone is ivory";
}

TEST(PresetTransferFunctionTest, AnUnknownNameListsTheKnownOnes) {
  EXPECT_TRUE(test::rejects(preset_transfer_function("mri"), ErrorCode::kNotFound,
                            {"mri", "ct-bone", "ct-soft-tissue", "ct-liver", "cta-vessels",
                             "cta-liver-vessels", "mr-default"}));
}

}  // namespace
}  // namespace nav::render
