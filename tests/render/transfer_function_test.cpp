// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer_function.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

constexpr double kRounding = 1e-12;

std::vector<TransferNode> ramp() {
  return {{0, {0, 0.5, 1}, 0.0, 0.0}, {100, {1, 0.5, 0}, 0.5, 1.0}};
}

TEST(TransferFunctionTest, ExtinctionIsLinearInHuAndOpacityIsOfOneMillimetre) {
  const auto f = TransferFunction::create("ramp", ramp());
  ASSERT_TRUE(test::has_value(f));
  const TransferSample end = f->at(100);
  EXPECT_NEAR(-std::expm1(-end.tau_per_mm), 0.5, kRounding);
  const TransferSample quarter = f->at(25);
  EXPECT_NEAR(quarter.tau_per_mm, 0.25 * std::log(2.0), kRounding);
  EXPECT_NEAR(quarter.rgb.x(), 0.25, kRounding);
  EXPECT_NEAR(quarter.rgb.z(), 0.75, kRounding);
  EXPECT_NEAR(quarter.importance, 0.25, kRounding);
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
  EXPECT_NEAR(f->at(0).tau_per_mm / 1e-15, 1.0, kRounding);
}

TEST(TransferFunctionTest, NamesTheBadNode) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with = [](auto change) {
    auto nodes = ramp();
    change(nodes[1]);
    return TransferFunction::create("bad", nodes);
  };
  const auto refused = [](const auto& f, std::initializer_list<std::string> pieces) {
    return test::refuses(f, ErrorCode::kMalformedData, pieces);
  };
  EXPECT_TRUE(refused(TransferFunction::create("bad", {ramp()[0]}), {"bad", "two nodes", "1"}));
  EXPECT_TRUE(refused(with([](auto& n) { n.hu = 0; }), {"node 1", "more than the 0 HU"}));
  EXPECT_TRUE(refused(with([&](auto& n) { n.hu = nan; }), {"node 1", "finite"}));
  EXPECT_TRUE(refused(with([](auto& n) { n.rgb.y() = 1.5; }), {"node 1", "colours", "1.5"}));
  EXPECT_TRUE(refused(with([](auto& n) { n.opacity = 1; }), {"node 1", "opacity"}));
  EXPECT_TRUE(refused(with([&](auto& n) { n.opacity = nan; }), {"node 1", "opacity"}));
  EXPECT_TRUE(refused(with([](auto& n) { n.importance = -0.1; }), {"node 1", "importance"}));
}

TEST(PresetTransferFunctionTest, ShowsWhatItsNamePromises) {
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
  // A plane under 100 mm of liver keeps a third of its light.
  EXPECT_GT(std::exp(-100 * soft->at(110).tau_per_mm), 0.33);
  EXPECT_GT(soft->at(110).tau_per_mm, 0);
  const TransferSample artery = vessels->at(330);
  EXPECT_GT(artery.rgb.x(), 4 * artery.rgb.y()) << "contrast is red";
  EXPECT_GT(artery.tau_per_mm * 3, 0.7) << "a vessel of 3 mm shows";
  EXPECT_GT(vessels->at(900).rgb.y(), 0.8) << "bone is ivory";
}

TEST(PresetTransferFunctionTest, ListsTheKnownOnes) {
  EXPECT_TRUE(test::refuses(preset_transfer_function("mri"), ErrorCode::kNotFound,
                            {"mri", "ct-bone", "ct-soft-tissue", "cta-vessels"}));
}

}  // namespace
}  // namespace nav::render
