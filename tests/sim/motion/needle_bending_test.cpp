// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/needle_bending.hpp"

#include <gtest/gtest.h>
#include <numbers>

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

NeedleBending of(BendingKind kind) {
  NeedleBending bending;
  bending.kind = kind;
  return bending;
}

TEST(NeedleBendingTest, ATipOfAStraightNeedleIsAtItsOrigin) {
  const BentNeedle needle(of(BendingKind::kStraight), 80);
  EXPECT_EQ(needle.tip_error_mm(), 0);
  EXPECT_LE((needle.at(0).mm - Vec(0, 0, -80)).norm(), 1e-12);
}

TEST(NeedleBendingTest, ABevelTipFollowsACircle) {
  NeedleBending bending = of(BendingKind::kBevelArc);
  bending.curvature_per_mm = 5e-3;
  bending.bevel_rad = 1.1;
  const BentNeedle needle(bending, 100);
  const Vec aside(std::cos(1.1), std::sin(1.1), 0);
  const Vec centre = 200 * aside + Vec(0, 0, -100);
  for (double arc = 0; arc <= 100; arc += 10) {
    EXPECT_NEAR((needle.at(arc).mm - centre).norm(), 200, 1e-9);
    EXPECT_NEAR((needle.at(arc).mm - centre).dot(needle.direction(arc).v), 0, 1e-9);
  }
  EXPECT_NEAR(needle.tip().mm.dot(aside), 200 * (1 - std::cos(0.5)), 1e-9);
}

TEST(NeedleBendingTest, ATipLoadBendsTheNeedleLikeACantilever) {
  NeedleBending bending = of(BendingKind::kTipLoad);
  bending.bevel_rad = 0;
  const BentNeedle needle(bending, 100);
  const double inertia = std::numbers::pi * (std::pow(0.9, 4) - std::pow(0.6, 4)) / 64;
  const double expected = 0.05 * 1e6 / (3 * 200e3 * inertia);
  EXPECT_NEAR(needle.tip().mm.x(), expected, 1e-9);
  EXPECT_EQ(needle.at(0).mm.x(), 0);
  EXPECT_LE((needle.direction(0).v - Vec::UnitZ()).norm(), 1e-12);
}

TEST(NeedleBendingTest, DirectionIsTheTangent) {
  for (const auto kind : {BendingKind::kBevelArc, BendingKind::kTipLoad}) {
    const BentNeedle needle(of(kind), 120);
    for (double arc = 1; arc < 119; arc += 13) {
      const Vec chord = (needle.at(arc + 0.01).mm - needle.at(arc - 0.01).mm).normalized();
      EXPECT_LE((chord - needle.direction(arc).v).norm(), 1e-7);
    }
  }
}

TEST(NeedleBendingTest, AlmostStraightNeedlesHaveNoCancellation) {
  NeedleBending bending = of(BendingKind::kBevelArc);
  for (const double curvature : {1e-15, 1e-9, 1e-6, 1.9e-6, 2.1e-6}) {
    bending.curvature_per_mm = curvature;
    const BentNeedle needle(bending, 100);
    EXPECT_NEAR(needle.tip().mm.x() / (0.5 * curvature * 1e4), 1, 1e-8) << curvature;
    EXPECT_LE(std::abs(needle.tip().mm.z()), 1e-5);
  }
}

TEST(NeedleBendingTest, TheTipDeviatesByTheRequestedDistance) {
  for (const auto kind : {BendingKind::kBevelArc, BendingKind::kTipLoad}) {
    for (const double path : {50., 90., 160.}) {
      for (const double aside : {0., 0.01, 1., 0.19 * path}) {
        NeedleBending asked = of(kind);
        asked.bevel_rad = 0.7;
        const auto bending = bending_aside(asked, path, aside);
        ASSERT_TRUE(bending) << bending.error().message;
        EXPECT_NEAR(BentNeedle(*bending, path).tip().mm.head<2>().norm(), aside, 1e-9 * path);
      }
    }
  }
  EXPECT_FALSE(bending_aside(of(BendingKind::kBevelArc), 80, 16.1));
  EXPECT_FALSE(bending_aside(of(BendingKind::kTipLoad), 80, -1));
  EXPECT_FALSE(bending_aside(of(BendingKind::kTipLoad), 0, 0));
}

TEST(NeedleBendingTest, NamesOfTheKindsReadBack) {
  for (const auto kind : {BendingKind::kStraight, BendingKind::kBevelArc, BendingKind::kTipLoad}) {
    EXPECT_EQ(*bending_kind_from(to_string(kind)), kind);
  }
  const auto refused = bending_kind_from("banana");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("banana"), std::string::npos);
}

TEST(NeedleBendingTest, RejectsInvalidOptions) {
  NeedleBending bending;
  bending.inner_mm = 1;
  EXPECT_FALSE(validate(bending));
  bending = {};
  bending.tip_force_n = std::nan("");
  EXPECT_FALSE(validate(bending));
}

}  // namespace
}  // namespace nav::sim
