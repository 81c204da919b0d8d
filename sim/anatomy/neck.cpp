// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "sim/anatomy/layout.hpp"

namespace nav::sim {
namespace {

using shapes::Capsule;
using shapes::Ellipsoid;
using shapes::smooth_step;

constexpr double kEndMm = 62;  // End of the region above and below.
constexpr double kNeckSkinMm = 1.8;
constexpr double kLevelMm = 17;        // Distance between vertebrae.
constexpr double kAdventitiaMm = 0.3;  // Apparent thickness of the echo.

/// Course of the carotid artery of one side, with its bifurcation. s: +1 left, -1 right.
struct Carotid {
  double s;
  double fork_z;     ///< Height at which the branches begin to diverge.
  double x, y;       ///< Position of the common carotid at the bifurcation.
  double tilt;       ///< Outward shift per mm upwards.
  double spread;     ///< Distance of the branches, mm.
  double common_mm;  ///< Radii.
  double internal_mm, external_mm, bulb_mm;
  double intima_media_mm;

  Carotid(double side, Random& random, double intima_media)
      : s(side),
        fork_z(random.uniform(0, 16)),
        x(random.uniform(23, 27)),
        y(random.uniform(-23, -19)),
        tilt(random.uniform(0.04, 0.10)),
        spread(random.uniform(5.0, 7.0)),
        common_mm(random.uniform(2.9, 3.4)),
        internal_mm(random.uniform(2.2, 2.6)),
        external_mm(random.uniform(1.8, 2.1)),
        bulb_mm(random.uniform(0.7, 1.3)),
        intima_media_mm(intima_media) {}

  /// Axis at a height; \p way: +1 internal (outwards, back), -1 external (inwards, front).
  template <class S>
  [[nodiscard]] Vec3<S> axis(const S& z, double way) const {
    using std::sin;
    const S part = smooth_step(S((z - fork_z + 3) / 30)) * (way * spread);
    const S bow = 1.2 * sin(0.07 * z + 1.1 * s);
    return {s * (x + tilt * (z - fork_z) + part + bow), y - 0.06 * (z - fork_z) + 0.55 * part, z};
  }
  template <class S>
  [[nodiscard]] S radius(const S& z, double way) const {
    using std::exp;
    const S t = z - fork_z;
    const S past = smooth_step(S((t + 4) / 12));
    const S bump = (t - 4) / 7;
    const double branch = way > 0 ? internal_mm : external_mm;
    const double bulb = way > 0 ? bulb_mm : 0.3;
    return common_mm + past * (branch - common_mm) + bulb * exp(-(bump * bump));
  }
  /// Distance to the lumen of one branch; below the bifurcation both are the common carotid.
  template <class S>
  [[nodiscard]] S branch(const Vec3<S>& p, double way) const {
    using std::hypot;
    const Vec3<S> c = axis(p.z(), way);
    // The axis is tilted to the slices by at most 0.3, so this is a first-order distance.
    return (hypot(S(p.x() - c.x()), S(p.y() - c.y())) - radius(p.z(), way)) * 0.97;
  }
  template <class S>
  [[nodiscard]] S lumen(const Vec3<S>& p) const {
    return std::min(branch(p, 1), branch(p, -1));
  }
  [[nodiscard]] double wall_mm() const { return intima_media_mm + kAdventitiaMm; }
  /// Double line of an artery: bright at the lumen, dark media, bright adventitia.
  [[nodiscard]] std::vector<WallLayer> wall_layers() const {
    return {{wall_mm() - 0.12, 0.16, 1.5}, {0.5 * kAdventitiaMm, kAdventitiaMm, 2.6}};
  }
  /// Point where the two lumens separate: the tip of the flow divider.
  [[nodiscard]] Vec3d divider() const {
    double z = fork_z;
    const auto apart = [&] { return (axis(z, 1) - axis(z, -1)).norm(); };
    constexpr double kTipMm = 0.2;  // Wall between the lumens.
    while (apart() < radius(z, 1) + radius(z, -1) + kTipMm) z += 0.01;
    const Vec3d inner = axis(z, 1);
    const Vec3d outer = axis(z, -1);
    return inner + (outer - inner) * ((radius(z, 1) + 0.5 * kTipMm) / apart());
  }
};

/// Parameters that differ between patients.
struct Neck {
  shapes::SuperEllipse body{54, 50};
  double fat_mm;
  double spine_phase_mm;

  explicit Neck(Random& random) {
    body = {random.uniform(52, 57), random.uniform(48, 52)};
    fat_mm = random.uniform(2.5, 4.5);
    spine_phase_mm = random.uniform(-9, 9);
  }
  /// Depth below the skin.
  template <class S>
  [[nodiscard]] S depth(const Vec3<S>& p) const {
    return -body(p);
  }
};

Eigen::AlignedBox3d column(double x0, double x1, double y0, double y1) {
  return {Vec3d(x0, y0, -kEndMm), Vec3d(x1, y1, kEndMm)};
}

void add_layers(const Neck& neck, Layout& layout) {
  layout.add(Tissue::kSkin, neck.body);
  layout.add(Tissue::kFat, [neck](const auto& p) { return kNeckSkinMm - neck.depth(p); });
  const double deep = kNeckSkinMm + neck.fat_mm;
  layout.add(Tissue::kFascia, [neck, deep](const auto& p) { return deep - neck.depth(p); });
  layout.add(
      Tissue::kMuscle, [neck, deep](const auto& p) { return deep + 0.6 - neck.depth(p); },
      muscle_grain(Vec3d(0, 0.15, 1)));
  // Fat that surrounds the viscera and vessels.
  const auto space = [](const auto& p) {
    using std::hypot;
    using S = ScalarOf<decltype(p)>;
    const S k = hypot(S(p.x() / 37), S((p.y() + 22) / 20));
    return (k - 1.0) * 20;
  };
  layout.add(Tissue::kFat, space, column(-43, 43, -48, 4));
}

/// Adds a band of muscle under the fat, about a line, in its sheath.
void add_band(const Neck& neck, const Vec3d& from, const Vec3d& to, double half_width_mm,
              double thick_mm, Layout& layout) {
  const double top = kNeckSkinMm + neck.fat_mm + 0.7;
  const Capsule line{from, to, half_width_mm};
  const auto band = [=](double more) {
    return [=](const auto& p) {
      using S = ScalarOf<decltype(p)>;
      const S depth = neck.depth(p);
      const S slab = std::max(S(top - depth), S(depth - top - thick_mm));
      return shapes::smooth_intersection(slab, line(p), 3) - more;
    };
  };
  const Eigen::AlignedBox3d bounds = box_around(line, 6);
  layout.add(Tissue::kFascia, band(0.5), bounds);
  layout.add(Tissue::kMuscle, band(0.0), bounds, muscle_grain(to - from));
}

void add_muscles(const Neck& neck, Layout& layout) {
  for (const double s : {-1.0, 1.0}) {
    add_band(neck, {s * 16, -52, -70}, {s * 50, 14, 70}, 15, 8.5, layout);  // Sternomastoid.
    add_band(neck, {s * 9, -50, -70}, {s * 9, -50, 60}, 8.5, 3.2, layout);  // Strap muscles.
    // Muscles in front of the spine.
    layout.add(Tissue::kMuscle, Capsule{{s * 8, -8, -80}, {s * 8, -8, 80}, 5},
               muscle_grain(Vec3d::UnitZ()));
    // Scalenes.
    layout.add(Tissue::kFascia, Capsule{{s * 30, 0, -70}, {s * 20, 2, 50}, 8.5});
    layout.add(Tissue::kMuscle, Capsule{{s * 30, 0, -70}, {s * 20, 2, 50}, 8},
               muscle_grain(Vec3d(-s * 10, 2, 120)));
  }
}

void add_airway(Layout& layout) {
  const auto tube = [](double radius) {
    return [radius](const auto& p) {
      using std::hypot;
      using S = ScalarOf<decltype(p)>;
      const S ring = hypot(p.x(), S(p.y() + 29)) - radius;
      // The back is flat.
      return shapes::smooth_intersection(ring, S(p.y() + 28 - 0.7 * radius), 3);
    };
  };
  layout.add(Tissue::kFascia, tube(10.6), column(-14, 14, -43, -16));
  layout.add(Tissue::kCartilage, tube(10.2), column(-14, 14, -43, -16));
  layout.add(Tissue::kGas, tube(8.2), column(-14, 14, -43, -16));
  const auto gullet = [](double rx, double ry) {
    return [rx, ry](const auto& p) {
      using std::hypot;
      using S = ScalarOf<decltype(p)>;
      return (hypot(S((p.x() - 6) / rx), S((p.y() + 16.5) / ry)) - 1.0) * ry;
    };
  };
  layout.add(Tissue::kBowelWall, gullet(8, 4), column(-6, 18, -24, -9));
  layout.add(Tissue::kBowelContent, gullet(3, 1), column(-6, 18, -24, -9));
}

void add_thyroid(Random& random, Layout& layout) {
  const double z = random.uniform(-22, -14);
  const double high = random.uniform(21, 27);
  const auto gland = [&](double more) {
    const Ellipsoid left{{16, -30, z}, {8.0 + more, 9.5 + more, high + more}, turned(0, 0.1, -0.3)};
    const Ellipsoid right{
        {-16, -30, z}, {8.0 + more, 9.5 + more, high + more}, turned(0, -0.1, 0.3)};
    const Ellipsoid isthmus{{0, -40.2, z - 3}, {15, 2.4 + more, 8 + more}};
    return [=](const auto& p) {
      using S = ScalarOf<decltype(p)>;
      const S lobes = std::min(left(p), right(p));
      return shapes::smooth_union(lobes, S(isthmus(p)), 3);
    };
  };
  const Eigen::AlignedBox3d bounds(Vec3d(-32, -52, z - 36), Vec3d(32, -14, z + 36));
  layout.add(Tissue::kFascia, gland(0.5), bounds);
  layout.add(Tissue::kThyroid, gland(0.0), bounds);
  const double side = random.uniform(-1, 1) < 0 ? -1.0 : 1.0;
  const double size = random.uniform(3, 5);
  const Vec3d nodule = Vec3d(side * 16, -30, z) + random.offset(3);
  layout.add(Tissue::kFascia, Ellipsoid{nodule, Vec3d(size + 0.4, size + 0.4, 1.3 * size + 0.4)});
  layout.add(Tissue::kLesion, Ellipsoid{nodule, Vec3d(size, size, 1.3 * size)});
  layout.mark("thyroid nodule", nodule);
  layout.mark("thyroid isthmus", {0, -40.2, z - 3});
  for (const double s : {-1.0, 1.0}) {
    const Vec3d up = turned(0, s * 0.1, -s * 0.3).col(2) * high;
    const std::string name = s < 0 ? "right thyroid lobe " : "left thyroid lobe ";
    layout.mark(name + "upper pole", Vec3d(s * 16, -30, z) + up);
    layout.mark(name + "lower pole", Vec3d(s * 16, -30, z) - up);
  }
}

void add_jugular(const Carotid& c, Random& random, Layout& layout) {
  const double rx = random.uniform(5.0, 7.0);
  const double ry = random.uniform(3.0, 4.2);
  const double phase = random.uniform(0, 6);
  const auto vein = [=](double more) {
    return [=](const auto& p) {
      using std::hypot, std::sin;
      using S = ScalarOf<decltype(p)>;
      const S width = rx + 0.8 * sin(0.08 * p.z() + phase) + more;
      const S x = p.x() - c.s * (c.x + 10.5 + 0.05 * p.z());
      const S y = p.y() - (c.y - 3.5 + 0.05 * p.z()) - c.s * 0.35 * x;
      return (hypot(S(x / width), S(y / (ry + more))) - 1.0) * (ry + more);
    };
  };
  const Eigen::AlignedBox3d bounds = c.s < 0 ? column(-52, -20, -42, -8) : column(20, 52, -42, -8);
  layout.add(Tissue::kFascia, vein(0.45), bounds);
  layout.add(Tissue::kVein, vein(0.0), bounds);
}

void add_plaque(const Carotid& c, Random& random, Layout& layout) {
  const double z = c.fork_z + random.uniform(2, 8);
  const double turn = random.uniform(0.5, 1.4);  // Plaque lies at the outer and back wall.
  const Vec3d axis = c.axis(z, 1);
  const Vec3d wall = Vec3d(c.s * std::cos(turn), std::sin(turn), 0);
  const Vec3d at = axis + c.radius(z, 1) * wall;
  const Ellipsoid lens{at,
                       {random.uniform(1.6, 2.2), random.uniform(1.6, 2.2), random.uniform(5, 8)}};
  layout.add(
      Tissue::kPlaque,
      [c, lens](const auto& p) {
        return std::max(lens(p), ScalarOf<decltype(p)>(c.branch(p, 1) - 0.3));
      },
      box_around(lens, 5));
  layout.add(Tissue::kCalcification, Ellipsoid{at - 0.5 * wall, {0.9, 0.9, 1.8}});
  layout.mark(c.s < 0 ? "right plaque" : "left plaque", at - 0.5 * wall);
}

void add_vessels(const Carotid& c, Random& random, Layout& layout) {
  add_jugular(c, random, layout);
  const Eigen::AlignedBox3d bounds = c.s < 0 ? column(-50, -8, -44, -2) : column(8, 50, -44, -2);
  const double wall_mm = c.wall_mm();
  layout.add(
      Tissue::kVesselWall, [c, wall_mm](const auto& p) { return c.lumen(p) - wall_mm; }, bounds);
  layout.organs.back().layers = c.wall_layers();
  // A thyroid artery that starts at the root of the external carotid.
  const Vec3d root = c.axis(c.fork_z + 9, -1);
  const Capsule branch{root, {c.s * 19, -35, c.fork_z - 2}, 0.8};
  layout.add(Tissue::kVesselWall, Capsule{branch.from, branch.to, 1.2});
  layout.organs.back().layers = {{0.2, 0.3, 1.3}};
  layout.add(Tissue::kArtery, branch);
  layout.add(
      Tissue::kArtery, [c](const auto& p) { return c.lumen(p); }, bounds);
  // The vagus nerve lies between and behind them, the vertebral artery beside the vertebrae.
  const auto nerve = [c](const auto& p) {
    using std::hypot;
    using S = ScalarOf<decltype(p)>;
    const auto a = c.axis(S(p.z()), 1);
    return hypot(S(p.x() - a.x() - c.s * 4.8), S(p.y() - a.y() - 4.2)) - 1.1;
  };
  layout.add(
      Tissue::kFascia, [nerve](const auto& p) { return nerve(p) - 0.35; }, bounds);
  layout.add(Tissue::kNerve, nerve, bounds);
  add_plaque(c, random, layout);
  const std::string side = c.s < 0 ? "right " : "left ";
  layout.mark(side + "carotid bifurcation", c.divider());
}

/// Vertebrae of the neck: bodies, discs, arches, transverse processes with the vertebral arteries.
void add_spine(const Neck& neck, Layout& layout) {
  const double phase = neck.spine_phase_mm;
  const auto level = [phase](const auto& z) {
    using std::round;
    return z - phase - kLevelMm * round((z - phase) / kLevelMm);
  };
  const auto body = [level](double less) {
    return [level, less](const auto& p) {
      using std::abs, std::hypot;
      using S = ScalarOf<decltype(p)>;
      const S k = hypot(S(p.x() / 11), S((p.y() - 6) / 8));
      return std::max(S((k - 1.0) * 8), S(abs(level(p.z())) - 6.2)) + less;
    };
  };
  const auto arch = [level](const auto& p) {
    using std::abs, std::hypot;
    using S = ScalarOf<decltype(p)>;
    const S z = level(p.z());
    const S ring = abs(hypot(p.x(), S(p.y() - 21)) - 9.5) - 1.8;
    const S spinous = std::max(S(abs(p.x()) - 2), S(abs(p.y() - 36) - 7));
    const S wing = std::max(S(hypot(S(p.y() - 8), z) - 3.5), S(abs(p.x()) - 22));
    const S hole = 3 - hypot(S(abs(p.x()) - 15), S(p.y() - 8));
    const S rear = std::max(std::min(ring, spinous), S(abs(z) - 4.5));
    return std::min(rear, std::max(wing, hole));
  };
  const auto bounds = column(-28, 28, -6, 50);
  const auto disc = [](const auto& p) {
    using std::hypot;
    using S = ScalarOf<decltype(p)>;
    return (hypot(S(p.x() / 10.5), S((p.y() - 6) / 7.5)) - 1.0) * 7.5;
  };
  layout.add(Tissue::kDisc, disc, bounds);
  const auto canal = [](const auto& p) {
    using std::hypot;
    return hypot(p.x(), ScalarOf<decltype(p)>(p.y() - 21)) - 7.6;
  };
  layout.add(Tissue::kSpinalCanal, canal, bounds);
  for (const double s : {-1.0, 1.0}) {
    layout.add(Tissue::kArtery, Capsule{{s * 15, 8, -90}, {s * 15, 8, 90}, 1.8});
  }
  layout.add(Tissue::kBone, body(0.0), bounds);
  layout.add(Tissue::kBone, arch, bounds);
  layout.add(Tissue::kMarrow, body(1.2), bounds);
}

void add_views(const Carotid& right, const Carotid& left, Layout& layout) {
  ProbeModel probe = linear_l14();
  probe.depth_mm = 45;
  probe.focus_mm = 20;
  const Vec3d fork = right.divider();
  const Vec3d out = Vec3d(-0.80, -0.60, 0);
  layout.view("right carotid, across", probe, fork - Vec3d(0, 0, 12), out, Vec3d(0.6, -0.8, 0));
  layout.view("right carotid, along", probe, right.axis(right.fork_z, 1), out, Vec3d::UnitZ());
  layout.view("left carotid, across", probe, left.divider(), Vec3d(0.80, -0.60, 0),
              Vec3d(0.6, 0.8, 0));
  layout.view("thyroid", probe, {0, -24, -18}, -Vec3d::UnitY(), Vec3d::UnitX());
}

}  // namespace

Patient make_neck(const PatientOptions& options) {
  Random random(options.seed, 0x6e65636b);
  const Neck neck(random);
  Random walls(options.seed, 0x77616c6c);  // Adults: 0.6 to 0.8 mm.
  const Carotid right(-1, random, walls.uniform(0.6, 0.8));
  const Carotid left(1, random, walls.uniform(0.6, 0.8));
  Layout layout;
  layout.box = {Vec3d(-62, -58, -kEndMm), Vec3d(62, 58, kEndMm)};
  layout.region = {Vec3d(-60, -56, -55), Vec3d(60, 56, 55)};
  layout.skin_mm = neck.body;
  add_layers(neck, layout);
  add_muscles(neck, layout);
  add_spine(neck, layout);
  add_airway(layout);
  add_thyroid(random, layout);
  add_vessels(right, random, layout);
  add_vessels(left, random, layout);
  layout.mark("trachea, front", {0, -39.2, -20});
  add_views(right, left, layout);
  constexpr double kReachMm = 35;
  const Vec3d near[] = {right.divider(), left.divider()};
  layout.place_targets(150, [&](const Vec3d& p) {
    return neck.depth(p) > 5 && std::min((p - near[0]).norm(), (p - near[1]).norm()) < kReachMm;
  });
  return finish("neck", options, std::move(layout));
}

}  // namespace nav::sim
