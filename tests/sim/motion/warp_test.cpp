// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/warp.hpp"

#include <gmock/gmock.h>

#include "sim/motion/deformation.hpp"
#include "sim/motion/moved_field.hpp"
#include "sim/random.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using Mat = Eigen::Matrix3d;
using ::testing::HasSubstr;

constexpr double kTwiceTheTolerance = 2 * Warp::kInverseToleranceMm;

Mat numeric_jacobian(const Warp& warp, const Vec& p) {
  constexpr double kStepMm = 1e-3;
  Mat j;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec step = kStepMm * Vec::Unit(axis);
    j.col(axis) = (warp.apply(p + step) - warp.apply(p - step)) / (2 * kStepMm);
  }
  return j;
}

SmoothWarp smooth(std::vector<WarpBump> bumps) {
  auto warp = SmoothWarp::create(std::move(bumps));
  EXPECT_TRUE(warp.has_value()) << warp.error().message;
  return std::move(*warp);
}

std::vector<WarpBump> three_bumps() {
  return {{{-60, 0, 10}, {90, 70, 80}, {1, -6, -20}},
          {{40, -30, 0}, {60, 60, 50}, {8, 5, 0}},
          {{0, 60, -50}, {45, 50, 70}, {0, -4, 7}}};
}

void expect_consistent(const Warp& warp, double scale_mm) {
  Random random(7, 1);
  for (int i = 0; i < 200; ++i) {
    const Vec p = random.offset(scale_mm);
    EXPECT_LE((warp.apply(warp.invert(p)) - p).norm(), kTwiceTheTolerance) << p.transpose();
    EXPECT_LE((warp.invert(warp.apply(p)) - p).norm(), 20 * kTwiceTheTolerance);
    // Central differences over 1 mm / 1000 have an error of order 1e-6 / (20 mm)², plus rounding.
    EXPECT_LE((numeric_jacobian(warp, p) - warp.jacobian(p)).norm(), 1e-7);
    EXPECT_GT(warp.jacobian(p).determinant(), 0);
  }
}

TEST(WarpTest, JacobianAndInverseOfEveryKindAgreeWithTheMap) {
  expect_consistent(AffineWarp::rigid({0.1, -0.2, 0.05}, {10, 20, 30}, {1, -4, -12}), 200);
  Mat m = Mat::Identity();
  m << 1.05, 0.1, 0, -0.05, 0.9, 0.02, 0, 0.07, 1.1;
  expect_consistent(AffineWarp(m, {3, 2, 1}), 200);
  expect_consistent(smooth(three_bumps()), 200);
  const auto bent = std::make_shared<SmoothWarp>(smooth(three_bumps()));
  const auto turned = std::make_shared<AffineWarp>(
      AffineWarp::rigid({0.1, -0.2, 0.05}, {10, 20, 30}, {1, -4, -12}));
  expect_consistent(ComposedWarp(bent, turned), 200);
  expect_consistent(ComposedWarp(turned, bent), 200);
  const Vec p(11, -7, 23);
  EXPECT_EQ(ComposedWarp(bent, turned).apply(p), turned->apply(bent->apply(p)));
}

TEST(WarpTest, ARigidWarpKeepsDistancesAndItsCentre) {
  const auto warp = AffineWarp::rigid({0.2, 0.1, -0.3}, {10, 20, 30}, {1, 2, 3});
  EXPECT_LE((warp.apply({10, 20, 30}) - Vec(11, 22, 33)).norm(), 1e-12);
  EXPECT_NEAR((warp.apply({5, 5, 5}) - warp.apply({-7, 9, 2})).norm(),
              (Vec(5, 5, 5) - Vec(-7, 9, 2)).norm(), 1e-12);
}

TEST(WarpTest, ASmoothWarpPeaksAtItsCentreAndFadesAway) {
  const auto warp = smooth({{{-60, 0, 10}, {30, 30, 30}, {0, -4, -12}}});
  EXPECT_LE((warp.apply({-60, 0, 10}) - Vec(-60, -4, -2)).norm(), 1e-12);
  EXPECT_LE((warp.apply({140, 0, 10}) - Vec(140, 0, 10)).norm(), 1e-8);
}

TEST(WarpTest, ASmoothWarpKeepsDistancesAboveItsBound) {
  const auto warp = smooth(three_bumps());
  Random random(3, 2);
  for (int i = 0; i < 500; ++i) {
    const Vec a = random.offset(120);
    const Vec b = a + random.offset(20);
    EXPECT_GE((warp.apply(a) - warp.apply(b)).norm(),
              (1 - warp.lipschitz()) * (a - b).norm() - 1e-12);
  }
}

TEST(WarpTest, InverseConvergesForTheSteepestWarpAndFarFromTheOrigin) {
  const double peak = 0.9 * 20 * std::exp(0.5) * (1 - 1e-12);
  const auto steep = smooth({{Vec::Zero(), Vec::Constant(20), {peak, 0, 0}}});
  expect_consistent(steep, 60);
  const Vec far(1e4, -1e4, 1e4);
  const auto away = smooth({{far, {30, 30, 30}, {0, 10, -12}}});
  for (double x = -50; x <= 50; x += 5) {
    const Vec p = far + Vec(x, 0.3 * x, -x);
    EXPECT_LE((away.apply(away.invert(p)) - p).norm(), 2e-9);
  }
}

TEST(DeformationTest, MovesTheFarthestPointByTheRequestedDistance) {
  std::vector<Point<frames::Ct>> points;
  Random random(5, 4);
  for (int i = 0; i < 50; ++i) points.push_back({Vec(30, -20, 10) + random.offset(40)});
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const auto warp = make_deformation({8, seed}, points);
    ASSERT_TRUE(warp) << warp.error().message;
    double farthest = 0;
    for (const auto& p : points) farthest = std::max(farthest, (warp->apply(p.mm) - p.mm).norm());
    EXPECT_NEAR(farthest, 8, 1e-9);
    EXPECT_LT(warp->lipschitz(), 0.6);
  }
  EXPECT_FALSE(make_deformation({8, 1}, {}));
  const auto refused = make_deformation({21, 1}, points);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("0 to 20 mm, found 21"));
  EXPECT_FALSE(validate(DeformationOptions{std::nan(""), 1}));
}

TEST(MovedFieldTest, ValueAndGradientMoveWithTheTissue) {
  const auto warp = smooth(three_bumps());
  const auto value = [](const Vec& p) {
    return std::sin(0.05 * p.x()) * std::cos(0.04 * p.y()) + 0.03 * p.z();
  };
  const auto gradient = [](const Vec& p) {
    return Vec(0.05 * std::cos(0.05 * p.x()) * std::cos(0.04 * p.y()),
               -0.04 * std::sin(0.05 * p.x()) * std::sin(0.04 * p.y()), 0.03);
  };
  Random random(9, 3);
  for (int i = 0; i < 100; ++i) {
    const Vec rest = random.offset(120);
    const Vec now = warp.apply(rest);
    EXPECT_NEAR(moved_value(warp, now, value), value(rest), 1e-9);
    Vec numeric;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec step = 1e-2 * Vec::Unit(axis);
      numeric[axis] =
          (moved_value(warp, now + step, value) - moved_value(warp, now - step, value)) / 2e-2;
    }
    EXPECT_LE((numeric - moved_gradient(warp, now, gradient)).norm(), 1e-6);
  }
}

TEST(WarpTest, RejectsFoldingAndNonFiniteWarps) {
  const auto folds = SmoothWarp::create({{Vec::Zero(), {20, 20, 20}, {0, 0, 40}}});
  ASSERT_FALSE(folds);
  EXPECT_THAT(folds.error().message, HasSubstr("fold"));
  EXPECT_FALSE(SmoothWarp::create({{Vec::Zero(), {20, 0, 20}, {0, 0, 1}}}));
  EXPECT_FALSE(SmoothWarp::create({{Vec(std::nan(""), 0, 0), {20, 20, 20}, {0, 0, 1}}}));
}

}  // namespace
}  // namespace nav::sim
