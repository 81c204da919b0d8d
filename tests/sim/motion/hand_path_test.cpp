// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/hand_path.hpp"

#include <gtest/gtest.h>

#include "tests/sim/block.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using frames::Ct;
using frames::Image;

const Transform<Ct, Image> kMiddle(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec::UnitY())),
                                   {-80, -60, 20});

Timestamp time_at(double seconds) { return Timestamp(from_seconds(seconds)); }

HandPath make(HandPathKind kind) {
  HandPathOptions options;
  options.kind = kind;
  return {kMiddle, options};
}

Transform<Image, Image> from_middle(const HandPath& path, double seconds) {
  return kMiddle.inverse() * path.steady(time_at(seconds));
}

TEST(HandPathTest, PassesThroughItsMiddlePoseAtHalfTime) {
  for (const auto kind :
       {HandPathKind::kSweep, HandPathKind::kFan, HandPathKind::kRock, HandPathKind::kTilt}) {
    const auto middle = from_middle(make(kind), 2);
    EXPECT_LE(middle.translation_mm().norm(), 1e-9) << to_string(kind);
    EXPECT_LE(middle.rotation().angularDistance(Eigen::Quaterniond::Identity()), 1e-7);
  }
}

TEST(HandPathTest, SweepMovesAcrossThePlaneByItsLength) {
  const auto path = make(HandPathKind::kSweep);
  const auto begin = from_middle(path, 0);
  const auto end = from_middle(path, 4);
  EXPECT_LE((begin.translation_mm() - Vec(0, 0, -30)).norm(), 1e-9);
  EXPECT_LE((end.translation_mm() - Vec(0, 0, 30)).norm(), 1e-9);
  EXPECT_LE((from_middle(path, 99).translation_mm() - Vec(0, 0, 30)).norm(), 1e-9);
}

TEST(HandPathTest, FanAndRockRotateAboutTheirAxes) {
  const Point<Image> deep{{0, 100, 0}};
  const auto fan = from_middle(make(HandPathKind::kFan), 4);
  EXPECT_LE((fan * Point<Image>{Vec::Zero()}).mm.norm(), 1e-9);
  EXPECT_LE(((fan * deep).mm - Vec(0, 100 * std::cos(0.45), 100 * std::sin(0.45))).norm(), 1e-9);
  const auto rock = from_middle(make(HandPathKind::kRock), 4);
  EXPECT_LE(((rock * deep).mm - Vec(-100 * std::sin(0.45), 100 * std::cos(0.45), 0)).norm(), 1e-9);
}

TEST(HandPathTest, MovesFromItsEndToAPoseAndHoldsIt) {
  HandPath path = make(HandPathKind::kSweep);
  const Transform<Ct, Image> view(Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Vec::UnitX())),
                                  {-40, -90, 0});
  path.hold(view, time_at(6));
  const auto end = path.steady(time_at(4));
  EXPECT_LE((from_middle(path, 4).translation_mm() - Vec(0, 0, 30)).norm(), 1e-9);
  EXPECT_LE((path.steady(time_at(5)).translation_mm() -
             0.5 * (end.translation_mm() + view.translation_mm()))
                .norm(),
            1e-9);
  for (const double seconds : {6.0, 9.0}) {
    const auto held = path.steady(time_at(seconds));
    EXPECT_LE((held.translation_mm() - view.translation_mm()).norm(), 1e-9);
    EXPECT_LE(held.rotation().angularDistance(view.rotation()), 1e-7);
  }
  EXPECT_THROW(path.hold(view, time_at(4)), Bug);
}

TEST(HandPathTest, TiltSwingsBothWaysWhileItMoves) {
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

TEST(HandPathTest, TremorIsSmoothAndHasItsStandardDeviation) {
  HandTremor tremor;
  double sum = 0, square = 0, jerk = 0;
  int count = 0;
  for (double s = 0.002; s < 400; s += 0.02) {
    const auto w = wobble_at(tremor, time_at(s));
    sum += w.shift_mm.sum() / 3;
    square += w.shift_mm.squaredNorm() / 3;
    ++count;
    jerk = std::max(jerk,
                    std::abs(wobble_at(tremor, time_at(s + 1e-3)).shift_mm.x() - w.shift_mm.x()));
  }
  EXPECT_NEAR(sum / count, 0, 0.02);
  EXPECT_NEAR(std::sqrt(square / count), std::hypot(0.8, 0.08), 0.02);
  // 0.08 mm at 12 Hz and 0.8 mm at 1 Hz, at most √8 of it together: 35 mm/s.
  EXPECT_LT(jerk, 0.035);
}

TEST(HandPathTest, TheSeedDeterminesTheTremor) {
  HandTremor a, b;
  b.seed = 2;
  EXPECT_EQ(wobble_at(a, time_at(3)).turn_rad, wobble_at(a, time_at(3)).turn_rad);
  EXPECT_NE(wobble_at(a, time_at(3)).turn_rad, wobble_at(b, time_at(3)).turn_rad);
}

TEST(HandPathTest, RejectsInvalidOptions) {
  HandPathOptions options;
  options.length_mm = std::nan("");
  EXPECT_FALSE(validate(options));
  options = {};
  options.end = options.begin;
  EXPECT_FALSE(validate(options));
  EXPECT_FALSE(hand_path_kind_from("zigzag"));
  EXPECT_EQ(*hand_path_kind_from("rock"), HandPathKind::kRock);
}

/// Cylindrical body around the z axis.
class Barrel final : public Anatomy {
 public:
  explicit Barrel(double radius_mm) : radius_mm_(radius_mm) {}
  [[nodiscard]] std::string name() const override { return "barrel"; }
  [[nodiscard]] Tissue tissue(const Point<frames::Ct>&) const override { return Tissue::kLiver; }
  [[nodiscard]] double hu(const Point<frames::Ct>&) const override { return 0; }
  [[nodiscard]] ValueAndGradient hu_with_gradient(const Point<frames::Ct>&) const override {
    return {0, {Vec::Zero()}};
  }
  [[nodiscard]] Acoustics acoustics(const Point<frames::Ct>&) const override {
    return tissue_acoustics(Tissue::kLiver);
  }
  [[nodiscard]] double skin_distance_mm(const Point<frames::Ct>& p) const override {
    return p.mm.head<2>().norm() - radius_mm_;
  }
  [[nodiscard]] Eigen::AlignedBox3d region_mm() const override {
    return {Vec::Constant(-200), Vec::Constant(200)};
  }
  [[nodiscard]] std::vector<NamedPoint> landmarks() const override { return {}; }
  [[nodiscard]] std::vector<Point<frames::Ct>> targets() const override { return {}; }

 private:
  double radius_mm_;
};

TEST(HandPathTest, ASweepOnTheSkinKeepsItsDepthAndAngle) {
  constexpr double kRadius = 60, kPress = 3, kLength = 50;
  const Barrel patient(kRadius);
  // The probe looks from the front and leans by 0.2 rad across the path. The path leads around the
  // body.
  Eigen::Matrix3d axes;
  axes << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  const Transform<Ct, Image> middle(
      (Eigen::Quaterniond(axes) * Eigen::AngleAxisd(0.2, Vec::UnitX())).normalized(),
      {0, -(kRadius - kPress), 10});
  HandPathOptions options;
  options.length_mm = kLength;
  const HandPath path(patient, middle, options);
  // A chord between poses one millimetre apart lies 0.002 mm below the skin.
  EXPECT_LE((path.steady(time_at(2)).translation_mm() - middle.translation_mm()).norm(), 1e-9);
  for (const double s : {0.0, 1.0, 1.7, 3.1, 4.0}) {
    const auto pose = path.steady(time_at(s));
    const Vec face = pose.translation_mm();
    EXPECT_NEAR(patient.skin_distance_mm({face}), -kPress, 5e-3) << s;
    const Vec inward = Vec(-face.x(), -face.y(), 0).normalized();
    EXPECT_NEAR(std::acos(inward.dot(pose.rotation() * Vec::UnitY())), 0.2, 5e-3) << s;
    EXPECT_NEAR(face.z(), 10, 1e-6) << s;
  }
  const double angle = kLength / 2 / (kRadius - kPress);
  const Vec end = path.steady(time_at(4)).translation_mm();
  EXPECT_LE(
      (end - (kRadius - kPress) * Vec(std::sin(angle), -std::cos(angle), 0) - Vec(0, 0, 10)).norm(),
      0.1);
}

}  // namespace
}  // namespace nav::sim
