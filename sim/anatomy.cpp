// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy.hpp"

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
constexpr double kSkinMm = 2;
constexpr double kSpineY = 47;

Box around(const Ellipsoid& e, double pad_mm) {
  const Vec half = (e.axes.cwiseAbs() * e.radii).array() + pad_mm;
  return {e.centre - half, e.centre + half};
}
Box around(const Capsule& c, double pad_mm) {
  const Vec half = Vec::Constant(c.radius + pad_mm);
  return {c.from.cwiseMin(c.to) - half, c.from.cwiseMax(c.to) + half};
}

void add(std::vector<Organ>& organs, Tissue tissue, const Ellipsoid& e) {
  organs.push_back({tissue, e, around(e, 6)});
}
void add(std::vector<Organ>& organs, Tissue tissue, const Capsule& c) {
  organs.push_back({tissue, c, around(c, 3)});
}
void add_everywhere(std::vector<Organ>& organs, Tissue tissue, Distance distance) {
  organs.push_back({tissue, std::move(distance), anatomy_bounds()});
}

Ellipsoid grown(Ellipsoid e, double mm) {
  e.radii.array() += mm;
  return e;
}

Eigen::Matrix3d turned(double about_x, double about_y, double about_z) {
  return (Eigen::AngleAxisd(about_z, Vec::UnitZ()) * Eigen::AngleAxisd(about_y, Vec::UnitY()) *
          Eigen::AngleAxisd(about_x, Vec::UnitX()))
      .toRotationMatrix();
}

double smooth_step(double t) {
  const double s = std::clamp(t, 0.0, 1.0);
  return s * s * (3 - 2 * s);
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

double Build::fat_thickness_mm(const Vec& p) const {
  return fat_mm * (1.0 + 0.35 * std::abs(p.y()) / body.b);
}

double Build::wall_thickness_mm(const Vec& p) const {
  // Back muscles fill the space behind the organs.
  const double back = smooth_step((p.y() / body.b - 0.25) / 0.7);
  return kSkinMm + fat_thickness_mm(p) + 9.0 + 16.0 * back;
}

double Build::cavity_mm(const Vec& p) const { return body(p) + wall_thickness_mm(p); }

double Build::abdomen_mm(const Vec& p) const {
  const double domes = shapes::smooth_union(right_dome(p), left_dome(p), 25);
  return shapes::smooth_union(domes, p.z() + 18, 25);
}

double Build::liver_mm(const Vec& p) const {
  double d = shapes::smooth_union(right_lobe(p), left_lobe(p), 25);
  d = shapes::smooth_difference(d, visceral(p), 18);
  d = shapes::smooth_difference(d, right_kidney(p) - 5, 12);
  // Low waves: no two livers have the same outline.
  d += 1.8 * std::sin(0.055 * p.x() + wave_phase[0]) * std::sin(0.05 * p.y() + wave_phase[1]) +
       1.5 * std::sin(0.06 * p.z() + wave_phase[2]) * std::sin(0.045 * p.x() + wave_phase[3]);
  d = shapes::smooth_intersection(d, abdomen_mm(p) + 3.5, 8);
  return shapes::smooth_intersection(d, cavity_mm(p) + 1.5, 8);
}

void add_body_wall(const Build& build, std::vector<Organ>& organs) {
  add_everywhere(organs, Tissue::kSkin, build.body);
  add_everywhere(organs, Tissue::kFat, [build](const Vec& p) { return build.body(p) + kSkinMm; });
  add_everywhere(organs, Tissue::kMuscle, [build](const Vec& p) {
    return build.body(p) + kSkinMm + build.fat_thickness_mm(p);
  });
  add_everywhere(organs, Tissue::kPeritonealFat,
                 [build](const Vec& p) { return build.cavity_mm(p); });
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
    // The patient lies on the back: gas gathers in front (-y) with a flat level.
    const double level_y = inside.centre.y() - inside.radii.y() * (1 - 2 * gas_share);
    organs.push_back(
        {Tissue::kGas,
         [inside, level_y](const Vec& p) { return std::max(inside(p), p.y() - level_y); },
         around(inside, 6)});
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
                    [spleen, build](const Vec& p) {
                      const double d =
                          shapes::smooth_intersection(spleen(p), build.abdomen_mm(p) + 4, 8);
                      return shapes::smooth_intersection(d, build.cavity_mm(p) + 2, 8);
                    },
                    around(spleen, 8)});
}

void add_kidneys(const Build& build, Random& random, std::vector<Organ>& organs) {
  for (const Ellipsoid* kidney : {&build.right_kidney, &build.left_kidney}) {
    add(organs, Tissue::kKidneyCortex, *kidney);
    const double side = kidney->centre.x() < 0 ? 1.0 : -1.0;  // Towards the spine.
    for (int i = 0; i < 10; ++i) {                            // Pyramids about the sinus.
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
  organs.push_back({Tissue::kLiver, [build](const Vec& p) { return build.liver_mm(p); },
                    Box(Vec(-140, -100, -90), Vec(90, 90, 100))});
  add(organs, Tissue::kGallbladderWall, grown(build.gallbladder, 2));
  add(organs, Tissue::kBile, build.gallbladder);
}

void add_great_vessels(std::vector<Organ>& organs) {
  organs.push_back({Tissue::kVenaCava,
                    [](const Vec& p) {
                      const double x = p.x() + 22 - 0.03 * p.z();
                      const double y = p.y() - 27 + 0.10 * std::max(p.z(), 0.0);
                      return std::hypot(x, y * 1.25) - 11.5;
                    },
                    Box(Vec(-50, -10, -kEndZMm), Vec(10, 60, kEndZMm))});
  organs.push_back({Tissue::kAorta,
                    [](const Vec& p) {
                      const double x = p.x() - 9 - 4 * std::sin(0.02 * p.z());
                      return std::hypot(x, p.y() - 22) - 10;
                    },
                    Box(Vec(-20, -10, -kEndZMm), Vec(40, 50, kEndZMm))});
}

void add_thorax(const Build& build, std::vector<Organ>& organs) {
  const Ellipsoid heart{{22, -38, 116}, {52, 42, 50}, turned(0, 0.3, 0)};
  const Box above(Vec(-168, -126, -40), Vec(168, 126, kEndZMm));
  const auto lung = [build, heart](const Vec& p) {
    const double chest = std::max(build.cavity_mm(p) + 1, -build.abdomen_mm(p));
    // Mediastinum: between the lungs, in front of the spine.
    const double middle = std::max(std::abs(p.x()) - 32, p.y() - 62);
    return shapes::smooth_difference(std::max(chest, -middle), heart(p), 6);
  };
  organs.push_back({Tissue::kDiaphragm, [lung](const Vec& p) { return lung(p) - 3; }, above});
  organs.push_back(
      {Tissue::kMuscle,
       [build, heart](const Vec& p) { return std::max(heart(p), 3 - build.abdomen_mm(p)); },
       around(heart, 5)});
  organs.push_back({Tissue::kLung, lung, above});
}

void add_spine(const Build& build, std::vector<Organ>& organs) {
  constexpr double kPeriodMm = 34;
  constexpr double kHalfBodyMm = 13.5;
  const double phase = build.spine_phase_mm;
  const auto level = [phase](double z) {
    return z - phase - kPeriodMm * std::round((z - phase) / kPeriodMm);
  };
  const auto column = [](const Vec& p, double rx, double ry) {
    const double k = std::hypot(p.x() / rx, (p.y() - kSpineY) / ry);
    return (k - 1.0) * ry;
  };
  const auto body = [level, column](const Vec& p) {
    const double z = level(p.z());
    const double waist = 1.0 - 0.12 * std::cos(std::numbers::pi * z / (2 * kHalfBodyMm));
    return std::max(column(p, 22 * waist, 16 * waist), std::abs(z) - kHalfBodyMm);
  };
  const auto arch = [level](const Vec& p) {
    const double z = std::abs(level(p.z()));
    const double ring = std::abs(std::hypot(p.x(), p.y() - 70) - 11.5) - 3;
    const double spinous = std::max(std::abs(p.x()) - 3, std::abs(p.y() - 86) - 8);
    const double transverse =
        std::max(std::hypot(p.y() - 68, level(p.z())) - 4, std::abs(p.x()) - 38);
    return std::min(std::max(std::min(ring, spinous), z - 10), transverse);
  };
  const Box bounds(Vec(-48, 20, -kEndZMm), Vec(48, 105, kEndZMm));
  organs.push_back({Tissue::kDisc, [column](const Vec& p) { return column(p, 21, 15); }, bounds});
  organs.push_back({Tissue::kSpinalCanal,
                    [](const Vec& p) { return std::hypot(p.x(), p.y() - 70) - 9; }, bounds});
  organs.push_back(
      {Tissue::kBone, [body, arch](const Vec& p) { return std::min(body(p), arch(p)); }, bounds});
  organs.push_back({Tissue::kMarrow, [body](const Vec& p) { return body(p) + 2.2; }, bounds});
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
      if (rib >= 4) continue;  // Floating below; the others reach the arch by cartilage.
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
