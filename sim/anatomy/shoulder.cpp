// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "sim/anatomy/layout.hpp"

namespace nav::sim {
namespace {

using shapes::Capsule;
using shapes::Ellipsoid;

constexpr double kShoulderSkinMm = 1.8;
constexpr double kTearRad = 0.85;  // Angle from +z towards the side of the arm.

/// Right shoulder about the centre of the humeral head: -x is outwards, -y is in front.
struct Shoulder {
  double head_mm, cuff_mm, fat_mm;
  Ellipsoid cap, trunk, tuberosity;
  Capsule shaft, arm;

  explicit Shoulder(Random& random)
      : head_mm(random.uniform(22.5, 25)),
        cuff_mm(random.uniform(4.6, 5.8)),
        fat_mm(random.uniform(3, 5.5)),
        cap{{0, 0, -10}, {random.uniform(45, 48), random.uniform(43, 46), 61}},
        trunk{{72, 8, -50}, {78, 62, 96}},
        tuberosity{{-17, random.uniform(-2, 2), 3}, {9, 11, 12}},
        shaft{{-5, 0, -20}, {-9, 0, -140}, 11.5},
        arm{{-4, 0, -20}, {-8, 0, -160}, 37} {}

  template <class S>
  [[nodiscard]] S skin(const Vec3<S>& p) const {
    return shapes::smooth_union(shapes::smooth_union(cap(p), arm(p), 14), trunk(p), 18);
  }
  template <class S>
  [[nodiscard]] S bone(const Vec3<S>& p) const {
    const S head = shapes::smooth_union(S(p.norm() - head_mm), tuberosity(p), 6);
    return shapes::smooth_union(head, shaft(p), 10);
  }
  /// Part of the rotator cuff within a shell of the bone.
  template <class S>
  [[nodiscard]] S shell(const Vec3<S>& p, double outer_mm) const {
    // It ends at the outer facet of the tuberosity and does not follow the shaft.
    const S end = 2.0 - p.z() - 0.15 * p.x();
    return shapes::smooth_intersection(S(bone(p) - outer_mm), end, 4);
  }
};

void add_layers(const Shoulder& s, Layout& layout) {
  layout.add(Tissue::kSkin, [s](const auto& p) { return s.skin(p); });
  layout.add(Tissue::kFat, [s](const auto& p) { return s.skin(p) + kShoulderSkinMm; });
  const double deep = kShoulderSkinMm + s.fat_mm;
  layout.add(Tissue::kFascia, [s, deep](const auto& p) { return s.skin(p) + deep; });
  layout.add(
      Tissue::kMuscle, [s, deep](const auto& p) { return s.skin(p) + deep + 0.5; },
      muscle_grain(Vec3d(0.25, 0, 1)));
  const auto within = [&](Tissue tissue, const Ellipsoid& e, const Grain& grain) {
    layout.add(
        tissue,
        [s, e, deep](const auto& p) {
          return std::max(e(p), ScalarOf<decltype(p)>(s.skin(p) + deep + 1.0));
        },
        box_around(e, 6), grain);
  };
  // Fat between the muscles of the trunk.
  within(Tissue::kFat, {{62, 0, -20}, {34, 26, 60}}, {});
  const auto muscle = [&](const Ellipsoid& e, const Vec3d& along) {
    within(Tissue::kFascia, grown(e, 0.5), {});
    within(Tissue::kMuscle, e, muscle_grain(along));
  };
  muscle({{58, 12, 27}, {38, 13, 9.5}}, Vec3d::UnitX());      // Supraspinatus.
  muscle({{45, -14, -14}, {32, 8, 30}}, Vec3d(1, 0.3, 0.3));  // Subscapularis.
  muscle({{48, 34, -10}, {34, 9, 30}}, Vec3d(1, -0.3, 0.3));  // Infraspinatus.
}

/// Adds the bursa, the tendons of the cuff in three pieces whose fibres follow the head, and
/// cartilage.
void add_cuff(const Shoulder& s, Layout& layout) {
  const double outer = 0.9 + s.cuff_mm;
  const Eigen::AlignedBox3d bounds(Vec3d(-44, -44, -24), Vec3d(44, 44, 44));
  const auto layer = [s](double mm) { return [s, mm](const auto& p) { return s.shell(p, mm); }; };
  layout.add(Tissue::kFascia, layer(outer + 1.9), bounds);  // Fat around the bursa.
  layout.add(Tissue::kFluid, layer(outer + 0.9), bounds);
  layout.add(Tissue::kFascia, layer(outer + 0.4), bounds);
  constexpr double kFirst = 0.45;  // Angle from +z towards the side, between the pieces.
  constexpr double kSecond = 1.1;
  const auto piece = [&](double low, double high) {
    const Vec3d from(-std::cos(low), 0, -std::sin(low));  // Normals of the dividing planes.
    const Vec3d to(-std::cos(high), 0, -std::sin(high));
    return [=](const auto& p) {
      using S = ScalarOf<decltype(p)>;
      const S above = -(from.cast<S>().dot(p));
      const S below = to.cast<S>().dot(p);
      return std::max(s.shell(p, outer), std::max(above, below));
    };
  };
  const auto fibres = [](double angle) {
    return Grain{Vec3d(std::cos(angle), 0, std::sin(angle)), 8, 0.4, 0.8};
  };
  layout.add(Tissue::kTendon, piece(-1.5, kFirst), bounds, fibres(0.1));
  layout.add(Tissue::kTendon, piece(kFirst, kSecond), bounds, fibres(0.78));
  layout.add(Tissue::kTendon, piece(kSecond, 2.6), bounds, fibres(1.35));
  layout.add(
      Tissue::kFluid,
      [s](const auto& p) {
        return shapes::smooth_intersection(ScalarOf<decltype(p)>(p.norm() - s.head_mm - 1.4),
                                           ScalarOf<decltype(p)>(10 - p.x()), 3);
      },
      bounds);
  layout.add(
      Tissue::kCartilage,
      [s](const auto& p) {
        return shapes::smooth_intersection(ScalarOf<decltype(p)>(p.norm() - s.head_mm - 0.9),
                                           ScalarOf<decltype(p)>(-9 - p.x()), 3);
      },
      bounds);
}

void add_bones(const Shoulder& s, Layout& layout) {
  layout.add(Tissue::kBone, [s](const auto& p) { return s.bone(p); });
  layout.add(Tissue::kMarrow, [s](const auto& p) { return s.bone(p) + 2.0; });
  const auto bone = [&](const Ellipsoid& e) {
    layout.add(Tissue::kBone, e);
    layout.add(Tissue::kMarrow, grown(e, -1.6));
  };
  const auto stick = [&](const Capsule& c) {
    layout.add(Tissue::kBone, c);
    layout.add(Tissue::kMarrow, Capsule{c.from, c.to, c.radius - 1.8});
  };
  bone({{33, 3, 0}, {6.5, 12, 17}});          // Glenoid.
  bone({{11, 12, 38}, {22, 13, 4.5}});        // Acromion.
  stick({{38, 6, -5}, {85, 30, -50}, 5});     // Blade of the scapula.
  stick({{20, -10, 32}, {110, -14, 16}, 5});  // Clavicle.
  stick({{36, -8, 16}, {19, -30, 13}, 4.5});  // Coracoid process.
}

void add_biceps(const Shoulder& s, Layout& layout) {
  // The tendon lies in its groove in front of the head, then along the shaft.
  const Vec3d top(-6, -s.head_mm - 3.5, 6);
  const Vec3d bottom(-8, -s.head_mm + 2, -70);
  const Vec3d way = (bottom - top).normalized();
  layout.add(Tissue::kFluid, Capsule{top, bottom, 3.1});
  layout.add(Tissue::kTendon, Capsule{top, bottom, 2.5}, Grain{way, 8, 0.35, 0.9});
  layout.mark("biceps tendon", top + 10 * way);
}

Vec3d add_tear(const Shoulder& s, Random& random, Layout& layout) {
  const double turn = kTearRad + random.uniform(-0.12, 0.12);
  const Vec3d out(-std::sin(turn), random.uniform(-0.1, 0.1), std::cos(turn));
  const Vec3d way = out.normalized();
  // Searches from the centre of the head for the centre of the tendon.
  double r = s.head_mm;
  while (s.bone(Vec3d(r * way)) < 0.9 + 0.55 * s.cuff_mm) r += 0.05;
  Eigen::Matrix3d axes;
  axes.col(0) = way;
  axes.col(1) = Vec3d::UnitY().cross(way).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  const Ellipsoid tear{r * way, {random.uniform(1.3, 2.0), random.uniform(3.5, 5), 4.5}, axes};
  const double outer = 0.9 + s.cuff_mm;
  layout.add(
      Tissue::kFluid,
      [s, tear, outer](const auto& p) {
        return std::max(tear(p), ScalarOf<decltype(p)>(s.shell(p, outer) + 0.4));
      },
      box_around(tear, 5));
  layout.mark("tear of the supraspinatus tendon", tear.centre);
  return tear.centre;
}

}  // namespace

Patient make_shoulder(const PatientOptions& options) {
  Random random(options.seed, 0x73686f756c646572);
  const Shoulder s(random);
  Layout layout;
  layout.box = {Vec3d(-60, -60, -95), Vec3d(115, 76, 64)};
  layout.region = {Vec3d(-56, -56, -75), Vec3d(70, 70, 58)};
  layout.blend = {0.45, 0.28};
  layout.skin_mm = [s](const auto& p) { return s.skin(p); };
  add_layers(s, layout);
  add_cuff(s, layout);
  const Vec3d tear = add_tear(s, random, layout);
  add_bones(s, layout);
  add_biceps(s, layout);
  layout.mark("centre of the humeral head", Vec3d::Zero());
  layout.mark("greater tuberosity", s.tuberosity.centre);
  layout.mark("acromion, outer edge", {-10.5, 12, 38});
  layout.mark("coracoid tip", {19, -30, 13});
  layout.mark("glenoid", {33, 3, 0});
  ProbeModel probe = linear_l14();
  probe.depth_mm = 45;
  probe.focus_mm = 20;
  probe.frequency_mhz = 10;
  const Vec3d out = tear.normalized();
  layout.view("supraspinatus, along", probe, tear, out, Vec3d(out.z(), 0, -out.x()));
  layout.view("supraspinatus, across", probe, tear, out, Vec3d::UnitY());
  layout.view("biceps, across", probe, {-6, -20, -4}, -Vec3d::UnitY(), Vec3d::UnitX());
  layout.place_targets(150, [&](const Vec3d& p) {
    return s.skin(p) < -5 && (p - tear).norm() < 38 && s.bone(p) > 0;
  });
  return finish("shoulder", options, std::move(layout));
}

}  // namespace nav::sim
