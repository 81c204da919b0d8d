// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "sim/anatomy/layout.hpp"

namespace nav::sim {
namespace {

using shapes::Capsule;
using shapes::Ellipsoid;

constexpr double kTendonSkinMm = 1.6;

/// Right leg above the heel; the Achilles tendon runs along z behind it (+y).
struct Leg {
  double fat_mm, thick_mm, half_width_mm, swelling_mm, lesion_z;
  shapes::SuperEllipse calf;
  Ellipsoid heel, calcaneus;

  explicit Leg(Random& random)
      : fat_mm(random.uniform(1.6, 3.2)),
        thick_mm(random.uniform(2.3, 2.9)),
        half_width_mm(random.uniform(6.0, 7.5)),
        swelling_mm(random.uniform(0.8, 2.0)),
        lesion_z(random.uniform(-12, 4)),
        calf{random.uniform(30, 34), random.uniform(35, 39)},
        heel{{0, 2, -64}, {30, 39, 34}},
        calcaneus{{0, 3, -62}, {random.uniform(18, 21), random.uniform(25, 27), 24}} {}

  template <class S>
  [[nodiscard]] S skin(const Vec3<S>& p) const {
    using std::hypot;
    const Vec3<S> q(p.x(), p.y() + 8.0, p.z());
    const S ridge = hypot(p.x(), S(p.y() - 23)) - 10.5;
    return shapes::smooth_union(shapes::smooth_union(calf.distance(q), ridge, 12), heel(p), 18);
  }
  template <class S>
  [[nodiscard]] S tendon(const Vec3<S>& p) const {
    using std::exp, std::hypot;
    const S wide = half_width_mm + 7.0 * shapes::smooth_step(S((p.z() - 15) / 60)) +
                   3.0 * shapes::smooth_step(S((-20 - p.z()) / 30));
    const S t = (p.z() - lesion_z) / 13;
    const S thick = thick_mm + swelling_mm * exp(-(t * t));
    const S tube = (hypot(S(p.x() / wide), S((p.y() - 26.5) / thick)) - 1.0) * thick;
    return shapes::smooth_intersection(tube, S(-58 - p.z()), 3);
  }
};

void add_layers(const Leg& leg, Layout& layout) {
  layout.add(Tissue::kSkin, [leg](const auto& p) { return leg.skin(p); });
  layout.add(Tissue::kFat, [leg](const auto& p) { return leg.skin(p) + kTendonSkinMm; });
  const double deep = kTendonSkinMm + leg.fat_mm;
  layout.add(Tissue::kFascia, [leg, deep](const auto& p) { return leg.skin(p) + deep; });
  // The fat pad in front of the tendon fills the space between muscles and bones.
  layout.add(Tissue::kFat, [leg, deep](const auto& p) { return leg.skin(p) + deep + 0.5; });
}

void add_muscle(const Capsule& c, Layout& layout) {
  layout.add(Tissue::kFascia, Capsule{c.from, c.to, c.radius + 0.5});
  layout.add(Tissue::kMuscle, c, muscle_grain(c.to - c.from));
}

void add_muscles_and_bones(const Leg& leg, Layout& layout) {
  add_muscle({{6, 6, 90}, {2, 9, -22}, 8.5}, layout);      // Long flexor of the great toe.
  add_muscle({{-16, 2, 90}, {-17, 2, -50}, 6}, layout);    // Deep flexors.
  add_muscle({{18, 8, 90}, {20, 6, -50}, 5}, layout);      // Peroneal muscles.
  add_muscle({{-2, -32, 90}, {-4, -30, -40}, 8}, layout);  // Extensors.
  const Ellipsoid soleus{{0, 13, 62}, {23, 12.5, 55}};
  layout.add(Tissue::kFascia, grown(soleus, 0.5));
  layout.add(Tissue::kMuscle, soleus, muscle_grain(Vec3d(0, 0.3, 1)));
  const auto bone = [&](const Capsule& c) {
    layout.add(Tissue::kBone, c);
    layout.add(Tissue::kMarrow, Capsule{c.from, c.to, c.radius - 3});
  };
  bone({{-8, -16, 110}, {-8, -16, -26}, 12});
  bone({{19, -8, 110}, {19, -8, -40}, 6});
  const Ellipsoid talus{{0, -18, -50}, {17, 20, 13}};
  for (const Ellipsoid& e : {talus, leg.calcaneus}) {
    layout.add(Tissue::kBone, e);
    layout.add(Tissue::kMarrow, grown(e, -1.6));
  }
  // Small saphenous vein and sural nerve.
  layout.add(Tissue::kVein, Capsule{{13, 21.5, 90}, {14, 20, -60}, 1.3});
  layout.add(Tissue::kNerve, Capsule{{16, 19.5, 90}, {17, 18, -60}, 1.1});
}

void add_tendon(const Leg& leg, Random& random, Layout& layout) {
  const auto tendon = [leg](const auto& p) { return leg.tendon(p); };
  layout.add(Tissue::kFascia, [leg](const auto& p) { return leg.tendon(p) - 0.45; });
  layout.add(Tissue::kTendon, tendon, Grain{Vec3d::UnitZ(), 14, 0.55, 0.95});
  const double side = random.uniform(-2, 2);
  const Ellipsoid worn{{side, 26, leg.lesion_z}, {3.6, 1.8, 9}};
  const Ellipsoid tear{{side, 25.6, leg.lesion_z}, {1.5, 0.8, random.uniform(3, 5)}};
  const auto within = [leg](const Ellipsoid& e) {
    return [leg, e](const auto& p) {
      return std::max(e(p), ScalarOf<decltype(p)>(leg.tendon(p) + 0.4));
    };
  };
  layout.add(Tissue::kLesion, within(worn), box_around(worn, 4),
             Grain{Vec3d::UnitZ(), 7, 0.5, 0.5});
  layout.add(Tissue::kFluid, within(tear), box_around(tear, 4));
  layout.add(Tissue::kFluid, Ellipsoid{{0, 21.6, -40}, {5.5, 1.1, 4}});  // Bursa.
  layout.mark("tear", tear.centre);
  layout.mark("tear, upper end", tear.centre + Vec3d(0, 0, tear.radii.z() - 0.3));
  layout.mark("tear, lower end", tear.centre - Vec3d(0, 0, tear.radii.z() - 0.3));
  layout.mark("bursa", {0, 21.6, -40});
}

}  // namespace

Patient make_tendon(const PatientOptions& options) {
  Random random(options.seed, 0x74656e646f6e);
  const Leg leg(random);
  Layout layout;
  layout.box = {Vec3d(-42, -58, -104), Vec3d(42, 48, 100)};
  layout.region = {Vec3d(-40, -52, -75), Vec3d(40, 44, 70)};
  layout.blend = {0.4, 0.25};
  layout.skin_mm = [leg](const auto& p) { return leg.skin(p); };
  add_layers(leg, layout);
  add_muscles_and_bones(leg, layout);
  add_tendon(leg, random, layout);
  const double back = leg.calcaneus.centre.y() + leg.calcaneus.radii.y();
  layout.mark("calcaneus, hindmost point", {0, back - 0.2, leg.calcaneus.centre.z()});
  layout.mark("junction of muscle and tendon", {0, 24, 25});
  ProbeModel probe = linear_l14();
  probe.depth_mm = 30;
  probe.focus_mm = 10;
  probe.frequency_mhz = 12;
  probe.lateral_fwhm_mm = 0.4;
  probe.elevation_fwhm_mm = 1.0;
  const Vec3d tear(0, 26, leg.lesion_z);
  layout.view("tendon, along", probe, tear, Vec3d::UnitY(), Vec3d::UnitZ());
  layout.view("tendon, across", probe, tear, Vec3d::UnitY(), Vec3d::UnitX());
  layout.view("insertion", probe, {0, 26, -42}, Vec3d::UnitY(), Vec3d::UnitZ());
  layout.place_targets(
      120, [&](const Vec3d& p) { return leg.skin(p) < -4 && (p - tear).norm() < 32 && p.y() > 8; });
  return finish("tendon", options, std::move(layout));
}

}  // namespace nav::sim
