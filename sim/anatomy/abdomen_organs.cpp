// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/abdomen_organs.hpp"

#include <cmath>
#include <numbers>

#include "nav/check.hpp"

namespace nav::sim {
namespace {

using shapes::Capsule;
using shapes::Ellipsoid;
using Vec = Eigen::Vector3d;
using Box = Eigen::AlignedBox3d;

constexpr double kEndZMm = 130;
constexpr double kSpineY = 47;
constexpr double kPeriodMm = 34;  // Period of the vertebrae.
constexpr double kHalfBodyMm = 13.5;

void add(std::vector<Organ>& organs, Tissue tissue, const Ellipsoid& e) {
  organs.push_back({tissue, e, box_around(e, 6)});
}
void add(std::vector<Organ>& organs, Tissue tissue, const Capsule& c) {
  organs.push_back({tissue, c, box_around(c, 3)});
}
void add_everywhere(std::vector<Organ>& organs, Tissue tissue, Field distance) {
  organs.push_back({tissue, std::move(distance), anatomy_bounds()});
}

}  // namespace

Eigen::AlignedBox3d anatomy_bounds() { return {Vec(-168, -126, -kEndZMm), Vec(168, 126, kEndZMm)}; }

Build::Build(std::uint64_t seed) {
  Random random(seed, 0x616e61746f6d79);
  const auto vary = [&](double share) { return 1.0 + random.uniform(-share, share); };
  body = {142 * vary(0.025), 100 * vary(0.03)};
  fat_mm = random.uniform(7, 11);
  for (double& phase : wave_phase) phase = random.uniform(0, 2 * std::numbers::pi);
  spine_phase_mm = random.uniform(-17, 17);
  right_dome = {Vec(-56, -4, 2) + random.offset(3), {75 * vary(0.04), 88, 86 * vary(0.05)}};
  left_dome = {Vec(58, 0, 0) + random.offset(3), {76 * vary(0.04), 86, 72 * vary(0.05)}};
  right_lobe = {Vec(-64, -2, 12) + random.offset(5),
                {64 * vary(0.06), 74 * vary(0.06), 80 * vary(0.07)},
                turned(random.uniform(-0.12, 0.12), 0.12 * vary(0.5), 0)};
  left_lobe = {Vec(0, -40, 28) + random.offset(6),
               {66 * vary(0.12), 34 * vary(0.1), 40 * vary(0.12)},
               turned(0, random.uniform(-0.3, 0.1), 0.15)};
  visceral = {Vec(18, 42, -68) + random.offset(5), Vec::Constant(82 * vary(0.05))};
  right_kidney = {Vec(-62, 44, -42) + random.offset(4),
                  {26 * vary(0.08), 22 * vary(0.08), 52 * vary(0.08)},
                  turned(-0.15, 0.22, 0.4)};
  left_kidney = {Vec(64, 44, -18) + random.offset(4),
                 {26 * vary(0.08), 22 * vary(0.08), 54 * vary(0.08)},
                 turned(-0.15, -0.22, -0.4)};
  gallbladder = {Vec(-44, -34, -40) + random.offset(4),
                 {14 * vary(0.15), 13 * vary(0.15), 32 * vary(0.12)},
                 turned(-0.6, 0.2 * vary(1.0), 0)};
}

void add_body_wall(const Build& build, std::vector<Organ>& organs) {
  add_everywhere(organs, Tissue::kSkin, build.body);
  add_everywhere(organs, Tissue::kFat, [build](const auto& p) { return build.body(p) + kSkinMm; });
  add_everywhere(organs, Tissue::kMuscle, [build](const auto& p) {
    return build.body(p) + kSkinMm + build.fat_thickness_mm(p);
  });
  add_everywhere(organs, Tissue::kPeritonealFat,
                 [build](const auto& p) { return build.cavity_mm(p); });
  for (const double side : {-1.0, 1.0}) {  // Psoas.
    add(organs, Tissue::kMuscle, Capsule{{side * 30, kSpineY + 2, -20}, {side * 46, 40, -140}, 15});
  }
}

void add_digestive(const Build& build, Random& random, std::vector<Organ>& organs) {
  const auto hollow = [&](const Ellipsoid& outside, double gas_share) {
    add(organs, Tissue::kBowelWall, outside);
    const Ellipsoid inside = grown(outside, -3);
    add(organs, Tissue::kBowelContent, inside);
    if (gas_share <= 0) return;
    // The patient is supine: gas collects in front (-y) with a flat level.
    const double level_y = inside.centre.y() - inside.radii.y() * (1 - 2 * gas_share);
    organs.push_back(
        {Tissue::kGas,
         [inside, level_y](const auto& p) { return std::max(inside(p), p.y() - level_y); },
         box_around(inside, 6)});
  };
  hollow({Vec(62, -22, 22) + random.offset(4), {34, 32, 40}, turned(0, -0.3, 0.2)}, 0.3);
  for (int i = 0; i < 9; ++i) {  // Small bowel and colon, below the liver and to the left.
    const double x = -25.0 + 34.0 * (i % 4);
    const double z = -58.0 - 30.0 * (i / 4);
    const Vec centre = Vec(x, -30 + 10 * ((i * 7) % 3), z) + random.offset(6);
    const Vec radii(random.uniform(12, 17), random.uniform(11, 16), random.uniform(12, 18));
    hollow({centre, radii, turned(random.uniform(-1, 1), 0, 0)}, i % 2 == 0 ? 0.35 : 0.0);
  }
  const Ellipsoid flexure{Vec(-92, -18, -98) + random.offset(4), {20, 22, 26}};
  hollow(flexure, 0.4);
  const Ellipsoid spleen{Vec(92, 34, 30) + random.offset(4), {22, 40, 46}, turned(0.3, 0.2, 0.3)};
  organs.push_back({Tissue::kSpleen,
                    [spleen, build](const auto& p) {
                      using S = ScalarOf<decltype(p)>;
                      const S d =
                          shapes::smooth_intersection(spleen(p), S(build.abdomen_mm(p) + 4), 8);
                      return shapes::smooth_intersection(d, S(build.cavity_mm(p) + 2), 8);
                    },
                    box_around(spleen, 8)});
}

void add_kidneys(const Build& build, Random& random, std::vector<Organ>& organs) {
  for (const Ellipsoid* kidney : {&build.right_kidney, &build.left_kidney}) {
    add(organs, Tissue::kKidneyCortex, *kidney);
    const double side = kidney->centre.x() < 0 ? 1.0 : -1.0;  // Direction towards the spine.
    for (int i = 0; i < 10; ++i) {                            // Pyramids around the sinus.
      const double turn = 2 * std::numbers::pi * i / 10 + random.uniform(-0.2, 0.2);
      const Vec local(0.58 * kidney->radii.x() * std::sin(3.1 * i),
                      0.6 * kidney->radii.y() * std::cos(turn),
                      0.64 * kidney->radii.z() * std::sin(turn));
      add(organs, Tissue::kKidneyMedulla,
          Ellipsoid{kidney->centre + kidney->axes * local, {5.5, 5.5, 7}, kidney->axes});
    }
    const Vec hilum = kidney->axes * Vec(side * 0.35 * kidney->radii.x(), 0, 0);
    add(organs, Tissue::kRenalSinus,
        Ellipsoid{kidney->centre + hilum, kidney->radii.cwiseProduct(Vec(0.55, 0.38, 0.5)),
                  kidney->axes});
  }
}

void add_liver(const Build& build, std::vector<Organ>& organs) {
  organs.push_back({Tissue::kLiver, [build](const auto& p) { return build.liver_mm(p); },
                    Box(Vec(-140, -100, -90), Vec(90, 90, 100))});
  add(organs, Tissue::kGallbladderWall, grown(build.gallbladder, 2));
  add(organs, Tissue::kBile, build.gallbladder);
}

void add_great_vessels(std::vector<Organ>& organs) {
  organs.push_back({Tissue::kVenaCava,
                    [](const auto& p) {
                      using std::hypot;
                      using S = ScalarOf<decltype(p)>;
                      const S x = p.x() + 22 - 0.03 * p.z();
                      const S y = p.y() - 27 + 0.10 * std::max(p.z(), S(0.0));
                      return hypot(x, S(y * 1.25)) - 11.5;
                    },
                    Box(Vec(-50, -10, -kEndZMm), Vec(10, 60, kEndZMm))});
  organs.push_back({Tissue::kAorta,
                    [](const auto& p) {
                      using std::hypot, std::sin;
                      using S = ScalarOf<decltype(p)>;
                      const S x = p.x() - 9 - 4 * sin(0.02 * p.z());
                      return hypot(x, S(p.y() - 22)) - 10;
                    },
                    Box(Vec(-20, -10, -kEndZMm), Vec(40, 50, kEndZMm))});
}

void add_thorax(const Build& build, std::vector<Organ>& organs) {
  const Ellipsoid heart{{22, -38, 116}, {52, 42, 50}, turned(0, 0.3, 0)};
  const Box above(Vec(-168, -126, -40), Vec(168, 126, kEndZMm));
  const auto lung = [build, heart](const auto& p) {
    using std::abs;
    using S = ScalarOf<decltype(p)>;
    const S chest = std::max(S(build.cavity_mm(p) + 1), S(-build.abdomen_mm(p)));
    // Mediastinum: between the lungs, in front of the spine.
    const S middle = std::max(S(abs(p.x()) - 32), S(p.y() - 62));
    return shapes::smooth_difference(std::max(chest, S(-middle)), heart(p), 6);
  };
  organs.push_back({Tissue::kDiaphragm, [lung](const auto& p) { return lung(p) - 3; }, above});
  organs.push_back({Tissue::kMuscle,
                    [build, heart](const auto& p) {
                      return std::max(heart(p), ScalarOf<decltype(p)>(3 - build.abdomen_mm(p)));
                    },
                    box_around(heart, 5)});
  organs.push_back({Tissue::kLung, lung, above});
}

void add_spine(const Build& build, std::vector<Organ>& organs) {
  const double phase = build.spine_phase_mm;
  const auto level = [phase](const auto& z) {
    using std::round;
    return z - phase - kPeriodMm * round((z - phase) / kPeriodMm);
  };
  const auto column = [](const auto& p, const auto& rx, const auto& ry) {
    using std::hypot;
    using S = ScalarOf<decltype(p)>;
    const S k = hypot(S(p.x() / rx), S((p.y() - kSpineY) / ry));
    return (k - 1.0) * ry;
  };
  const auto body = [level, column](const auto& p) {
    using std::abs, std::cos;
    using S = ScalarOf<decltype(p)>;
    const S z = level(p.z());
    const S waist = 1.0 - 0.12 * cos(std::numbers::pi * z / (2 * kHalfBodyMm));
    return std::max(S(column(p, S(22 * waist), S(16 * waist))), S(abs(z) - kHalfBodyMm));
  };
  const auto arch = [level](const auto& p) {
    using std::abs, std::hypot;
    using S = ScalarOf<decltype(p)>;
    const S z = abs(level(p.z()));
    const S ring = abs(hypot(p.x(), S(p.y() - 70)) - 11.5) - 3;
    const S spinous = std::max(S(abs(p.x()) - 3), S(abs(p.y() - 86) - 8));
    const S transverse = std::max(S(hypot(S(p.y() - 68), S(level(p.z()))) - 4), S(abs(p.x()) - 38));
    return std::min(std::max(std::min(ring, spinous), S(z - 10)), transverse);
  };
  const Box bounds(Vec(-48, 20, -kEndZMm), Vec(48, 105, kEndZMm));
  organs.push_back(
      {Tissue::kDisc, [column](const auto& p) { return column(p, 21.0, 15.0); }, bounds});
  organs.push_back({Tissue::kSpinalCanal,
                    [](const auto& p) {
                      using std::hypot;
                      return hypot(p.x(), ScalarOf<decltype(p)>(p.y() - 70)) - 9;
                    },
                    bounds});
  organs.push_back(
      {Tissue::kBone, [body, arch](const auto& p) { return std::min(body(p), arch(p)); }, bounds});
  organs.push_back({Tissue::kMarrow, [body](const auto& p) { return body(p) + 2.2; }, bounds});
}

void add_ribs(const Build& build, Random& random, std::vector<Organ>& organs) {
  constexpr int kRibs = 7;
  constexpr double kStepRad = 0.14;
  constexpr double kBackRad = std::numbers::pi / 2 + 0.28;
  const double shift = random.uniform(-8, 8);
  std::vector<Capsule> bones;
  std::vector<Capsule> cartilages;
  for (const double side : {-1.0, 1.0}) {
    for (int rib = 0; rib < kRibs; ++rib) {
      const double z_back = 178.0 - 25.0 * rib + shift;
      const double end = 4.60 - 0.24 * rib - (rib == kRibs - 1 ? 0.35 : 0.0);
      const auto at = [&](double angle) {
        const double t = 1.0 / build.body.gauge(std::cos(angle), std::sin(angle));
        Vec p(t * std::cos(angle), t * std::sin(angle), z_back - 30.0 * (angle - kBackRad));
        const double depth = kSkinMm + build.fat_thickness_mm(p) + 5.5;
        const double scale = 1.0 - depth / p.head<2>().norm();
        return Vec(side < 0 ? p.x() * scale : -p.x() * scale, p.y() * scale, p.z());
      };
      for (double a = kBackRad; a < end - 0.01; a += kStepRad) {
        bones.push_back({at(a), at(std::min(a + kStepRad, end)), 5.0});
      }
      if (rib >= 4) continue;  // The lower ribs are floating; the others join the arch.
      const Vec tip = at(end);
      const Vec arch(side * 8.0, -(build.body.b - 20), 66 + 12.0 * (3 - rib));
      cartilages.push_back({tip, 0.5 * (tip + arch) + Vec(0, -9, 0), 4.5});
      cartilages.push_back({0.5 * (tip + arch) + Vec(0, -9, 0), arch, 4.5});
    }
  }
  for (const Capsule& c : cartilages) add(organs, Tissue::kCartilage, c);
  for (const Capsule& c : bones) add(organs, Tissue::kBone, c);
  for (const Capsule& c : bones) add(organs, Tissue::kMarrow, Capsule{c.from, c.to, 2.6});
}

Vec halton_in(const Eigen::AlignedBox3d& box, int index) {
  const auto radical = [index](int base) {
    double f = 1;
    double r = 0;
    for (int i = index; i > 0; i /= base) {
      f /= base;
      r += f * (i % base);
    }
    return r;
  };
  return box.min() + box.sizes().cwiseProduct(Vec(radical(2), radical(3), radical(5)));
}

}  // namespace nav::sim
