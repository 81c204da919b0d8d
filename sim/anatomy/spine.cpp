// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "sim/anatomy/layout.hpp"

namespace nav::sim {
namespace {

using shapes::Capsule;
using shapes::Ellipsoid;

constexpr double kSpineSkinMm = 2.2;
constexpr double kCanalY = 58;

/// Identical lumbar vertebrae in the back of a trunk; +y is behind.
struct Lumbar {
  shapes::SuperEllipse trunk;
  double fat_mm, period_mm, phase_mm, sway_mm, lean_mm;

  explicit Lumbar(Random& random)
      : trunk{random.uniform(130, 145), random.uniform(92, 100)},
        fat_mm(random.uniform(5, 9)),
        period_mm(random.uniform(34, 38)),
        phase_mm(random.uniform(-17, 17)),
        sway_mm(random.uniform(-3, 3)),
        lean_mm(random.uniform(2, 5)) {}

  /// Position in the frame of the nearest vertebra, mm.
  template <class S>
  [[nodiscard]] Vec3<S> local(const Vec3<S>& p) const {
    using std::cos, std::round, std::sin;
    const S z = p.z() - phase_mm - period_mm * round((p.z() - phase_mm) / period_mm);
    return {p.x() - sway_mm * sin(0.03 * p.z()), p.y() + lean_mm * cos(0.022 * p.z()), z};
  }
  /// Inverse of local() for the vertebra \p level.
  [[nodiscard]] Vec3d global(const Vec3d& q, int level) const {
    const double z = q.z() + phase_mm + period_mm * level;
    return {q.x() + sway_mm * std::sin(0.03 * z), q.y() - lean_mm * std::cos(0.022 * z), z};
  }
  template <class S>
  [[nodiscard]] S body(const Vec3<S>& p) const {
    using std::abs, std::cos, std::hypot;
    const Vec3<S> q = local(p);
    const S waist = 1.0 - 0.10 * cos(q.z() * 0.11);
    const S k = hypot(S(q.x() / (24.0 * waist)), S((q.y() - 32) / (17.0 * waist)));
    return shapes::smooth_intersection(S((k - 1.0) * 17.0), S(abs(q.z()) - 0.38 * period_mm), 3);
  }
  /// Arch: pedicles, laminae, joints, transverse and spinous processes.
  template <class S>
  [[nodiscard]] S arch(const Vec3<S>& p) const {
    using std::abs;
    const Vec3<S> q = local(p);
    const Vec3<S> half(abs(q.x()), q.y(), q.z());
    static const std::array<Capsule, 4> sticks = {{
        {{12, 44, 5}, {13, 58, 5}, 4.5},    // Pedicle.
        {{14, 60, 3}, {2, 70, -5}, 3.4},    // Lamina.
        {{14, 59, 5}, {38, 64, 6}, 3.4},    // Transverse process.
        {{16, 63, 12}, {15, 64, -13}, 4.6}  // Joints above and below.
    }};
    S d = sticks[0](half);
    for (std::size_t i = 1; i < sticks.size(); ++i) {
      d = shapes::smooth_union(d, sticks[i](half), 3);
    }
    static const Ellipsoid spinous{{0, 78, -6}, {3.2, 13, 9}, turned(0.25, 0, 0)};
    return shapes::smooth_union(d, spinous(q), 3);
  }
};

void add_soft(const Lumbar& l, Layout& layout) {
  layout.add(Tissue::kSkin, l.trunk);
  layout.add(Tissue::kFat, [l](const auto& p) { return l.trunk(p) + kSpineSkinMm; });
  const double deep = kSpineSkinMm + l.fat_mm;
  layout.add(Tissue::kFascia, [l, deep](const auto& p) { return l.trunk(p) + deep; });
  layout.add(
      Tissue::kMuscle, [l, deep](const auto& p) { return l.trunk(p) + deep + 0.8; },
      muscle_grain(Vec3d(0, 0.05, 1)));
  // The belly in front of the spine, as fat.
  layout.add(Tissue::kPeritonealFat, [](const auto& p) {
    using std::hypot;
    using S = ScalarOf<decltype(p)>;
    return (hypot(S(p.x() / 105), S((p.y() + 22) / 52)) - 1.0) * 52.0;
  });
  for (const double s : {-1.0, 1.0}) {
    const auto muscle = [&](const Vec3d& at, double rx, double ry) {
      for (const double more : {0.6, 0.0}) {
        const auto rod = [=](const auto& p) {
          using std::hypot;
          using S = ScalarOf<decltype(p)>;
          const double small = std::min(rx, ry) + more;
          const S k =
              hypot(S((p.x() - s * at.x()) / (rx + more)), S((p.y() - at.y()) / (ry + more)));
          return (k - 1.0) * small;
        };
        layout.add(more > 0 ? Tissue::kFascia : Tissue::kMuscle, rod,
                   more > 0 ? Grain{} : muscle_grain(Vec3d(s * 0.05, 0, 1)));
      }
    };
    muscle({40, 36, 0}, 14, 17);  // Psoas.
    muscle({12, 73, 0}, 8, 9);    // Multifidus.
    muscle({34, 74, 0}, 15, 8);   // Erector spinae.
  }
  layout.add(Tissue::kAorta, Capsule{{10, 4, -200}, {10, 4, 200}, 9});
  layout.add(Tissue::kVenaCava, Capsule{{-18, 7, -200}, {-18, 7, 200}, 10});
}

void add_vertebrae(const Lumbar& l, Layout& layout) {
  const Eigen::AlignedBox3d bounds(Vec3d(-52, 4, layout.box.min().z()),
                                   Vec3d(52, 98, layout.box.max().z()));
  const auto rod = [l](double y, double rx, double ry) {
    return [=](const auto& p) {
      using std::hypot;
      using S = ScalarOf<decltype(p)>;
      const auto q = l.local(p);
      return (hypot(S(q.x() / rx), S((q.y() - y) / ry)) - 1.0) * std::min(rx, ry);
    };
  };
  layout.add(Tissue::kDisc, rod(32, 23, 16), bounds);
  layout.add(Tissue::kFat, rod(kCanalY, 10, 9), bounds);
  layout.add(Tissue::kDura, rod(kCanalY - 1, 8.2, 7.2), bounds);
  layout.add(Tissue::kSpinalCanal, rod(kCanalY - 1, 7.6, 6.6), bounds);
  layout.add(
      Tissue::kBone, [l](const auto& p) { return l.body(p); }, bounds);
  layout.add(
      Tissue::kBone, [l](const auto& p) { return l.arch(p); }, bounds);
  layout.add(
      Tissue::kMarrow, [l](const auto& p) { return l.body(p) + 1.8; }, bounds);
  layout.add(
      Tissue::kMarrow, [l](const auto& p) { return l.arch(p) + 1.8; }, bounds);
}

}  // namespace

Patient make_spine(const PatientOptions& options) {
  Random random(options.seed, 0x7370696e65);
  const Lumbar l(random);
  Layout layout;
  layout.box = {Vec3d(-150, -106, -95), Vec3d(150, 106, 95)};
  layout.region = {Vec3d(-80, -20, -80), Vec3d(80, 104, 80)};
  layout.cell_mm = 4;
  layout.skin_mm = l.trunk;
  add_soft(l, layout);
  add_vertebrae(l, layout);
  for (int level = -1; level <= 1; ++level) {
    const std::string name = "vertebra " + std::to_string(level + 2);
    layout.mark(name + " spinous process", l.global({0, 88, -8}, level));
    layout.mark(name + " right transverse process", l.global({-38, 64, 6}, level));
    layout.mark(name + " left transverse process", l.global({38, 64, 6}, level));
  }
  ProbeModel probe = convex_abdominal();
  probe.depth_mm = 90;
  probe.frequency_mhz = 5;
  probe.focus_mm = 45;
  const Vec3d lamina = l.global({0, 70, -5}, 0);
  layout.view("across", probe, lamina, Vec3d::UnitY(), Vec3d::UnitX());
  layout.view("along, beside the middle", probe, lamina + Vec3d(-16, 0, 0), Vec3d::UnitY(),
              Vec3d::UnitZ());
  layout.place_targets(150, [&](const Vec3d& p) {
    return l.trunk(p) < -10 && (p - lamina).norm() < 50 && p.y() > 30;
  });
  return finish("spine", options, std::move(layout));
}

}  // namespace nav::sim
