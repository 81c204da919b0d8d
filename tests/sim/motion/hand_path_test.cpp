// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/hand_path.hpp"

#include <gtest/gtest.h>

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using frames::Ct;
using frames::Image;

const Transform<Ct, Image> kMiddle(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec::UnitY())),
                                   {-80, -60, 20});

Timestamp at(double seconds) { return Timestamp(from_seconds(seconds)); }

HandPath make(HandPathKind kind) {
  HandPathOptions options;
  options.kind = kind;
  return {kMiddle, options};
}

Transform<Image, Image> from_middle(const HandPath& path, double seconds) {
  return kMiddle.inverse() * path.steady(at(seconds));
}

TEST(HandPathTest, PassesItsMiddleHalfWay) {
  for (const auto kind :
       {HandPathKind::kSweep, HandPathKind::kFan, HandPathKind::kRock, HandPathKind::kTilt}) {
    const auto middle = from_middle(make(kind), 2);
    EXPECT_LE(middle.translation_mm().norm(), 1e-9) << to_string(kind);
    EXPECT_LE(middle.rotation().angularDistance(Eigen::Quaterniond::Identity()), 1e-7);
  }
}

TEST(HandPathTest, SweepSlidesAcrossThePlaneByItsLength) {
  const auto path = make(HandPathKind::kSweep);
  const auto begin = from_middle(path, 0);
  const auto end = from_middle(path, 4);
  EXPECT_LE((begin.translation_mm() - Vec(0, 0, -30)).norm(), 1e-9);
  EXPECT_LE((end.translation_mm() - Vec(0, 0, 30)).norm(), 1e-9);
  EXPECT_LE((from_middle(path, 99).translation_mm() - Vec(0, 0, 30)).norm(), 1e-9);
}

TEST(HandPathTest, FanAndRockTurnInPlaceAboutTheirAxes) {
  const Point<Image> deep{{0, 100, 0}};
  const auto fan = from_middle(make(HandPathKind::kFan), 4);
  EXPECT_LE((fan * Point<Image>{Vec::Zero()}).mm.norm(), 1e-9);
  EXPECT_LE(((fan * deep).mm - Vec(0, 100 * std::cos(0.45), 100 * std::sin(0.45))).norm(), 1e-9);
  const auto rock = from_middle(make(HandPathKind::kRock), 4);
  EXPECT_LE(((rock * deep).mm - Vec(-100 * std::sin(0.45), 100 * std::cos(0.45), 0)).norm(), 1e-9);
}

TEST(HandPathTest, TiltSwingsToAndFroWhileItSlides) {
  const auto path = make(HandPathKind::kTilt);
  double most = 0, least = 0;
  for (double s = 0; s <= 4; s += 0.01) {
    const auto pose = from_middle(path, s);
    const double angle = 2 * std::atan2(pose.rotation().x(), pose.rotation().w());
    most = std::max(most, angle);
    least = std::min(least, angle);
  }
  EXPECT_NEAR(most, 0.45, 1e-3);
  EXPECT_NEAR(least, -0.45, 1e-3);
}

TEST(HandPathTest, WobbleHasItsStandardDeviationAndIsSmooth) {
  HandTremor tremor;
  double sum = 0, square = 0, jerk = 0;
  int count = 0;
  for (double s = 0.002; s < 400; s += 0.02) {
    const auto w = wobble_at(tremor, at(s));
    sum += w.shift_mm.sum() / 3;
    square += w.shift_mm.squaredNorm() / 3;
    ++count;
    jerk = std::max(jerk, std::abs(wobble_at(tremor, at(s + 1e-3)).shift_mm.x() - w.shift_mm.x()));
  }
  EXPECT_NEAR(sum / count, 0, 0.02);
  EXPECT_NEAR(std::sqrt(square / count), std::hypot(0.8, 0.08), 0.02);
  // 0.08 mm at 12 Hz and 0.8 mm at 1 Hz, at most √8 of it together: 35 mm/s.
  EXPECT_LT(jerk, 0.035);
}

TEST(HandPathTest, SameSeedSameHand) {
  HandTremor a, b;
  b.seed = 2;
  EXPECT_EQ(wobble_at(a, at(3)).turn_rad, wobble_at(a, at(3)).turn_rad);
  EXPECT_NE(wobble_at(a, at(3)).turn_rad, wobble_at(b, at(3)).turn_rad);
}

TEST(HandPathTest, RefusesWhatCannotBe) {
  HandPathOptions options;
  options.length_mm = std::nan("");
  EXPECT_FALSE(validate(options));
  options = {};
  options.end = options.begin;
  EXPECT_FALSE(validate(options));
  EXPECT_FALSE(hand_path_kind_from("zigzag"));
  EXPECT_EQ(*hand_path_kind_from("rock"), HandPathKind::kRock);
}

}  // namespace
}  // namespace nav::sim
