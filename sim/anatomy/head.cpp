// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "sim/anatomy/layout.hpp"

namespace nav::sim {
namespace {

using shapes::Capsule;
using shapes::Ellipsoid;

// Depths below the scalp, mm.
constexpr double kScalpMm = 2.0;
constexpr double kSkullMm = 5.5;
constexpr double kDiploeMm = 7.3;
constexpr double kInnerTableMm = 9.6;
constexpr double kDuraMm = 11.2;
constexpr double kFluidMm = 12.0;
constexpr double kCortexMm = 13.6;
constexpr double kWindowMm = 24;  // Radius of the craniotomy.

/// Cranial vault with the brain, about the centre of the head.
struct Head {
  Ellipsoid scalp;
  double phase[3];
  Vec3d tumour;
  Vec3d out;  ///< Direction from the tumour to the craniotomy.

  explicit Head(Random& random)
      : scalp{{0, 0, 0}, {random.uniform(72, 77), random.uniform(90, 96), random.uniform(82, 88)}} {
    for (double& p : phase) p = random.uniform(0, 6);
    tumour = Vec3d(-32, 5, 30) + random.offset(7);
    out = Vec3d(tumour.x(), 0.3 * tumour.y(), tumour.z()).normalized();
  }
  template <class S>
  [[nodiscard]] S depth(const Vec3<S>& p) const {
    return -scalp(p);
  }
  /// Folds of the cortex, [0, 1]; 1 at the bottom of a sulcus.
  template <class S>
  [[nodiscard]] S groove(const Vec3<S>& p) const {
    using std::sin;
    const S wave = sin(0.24 * p.x() + 1.3 * sin(0.11 * p.y() + phase[0]) + phase[1]) +
                   sin(0.22 * p.y() + 1.2 * sin(0.12 * p.z() + phase[2])) +
                   sin(0.23 * p.z() + 1.1 * sin(0.10 * p.x() + phase[1]));
    // Sulci are where the wave passes through zero.
    const S narrow = wave * wave * 3.0;
    return 1.0 / (1.0 + narrow * narrow);
  }
  template <class S>
  [[nodiscard]] S cortex(const Vec3<S>& p) const {
    return (kCortexMm + 9.0 * groove(p) - depth(p)) * 0.45;
  }
  template <class S>
  [[nodiscard]] S white(const Vec3<S>& p) const {
    return (kCortexMm + 3.4 + 13.0 * groove(p) - depth(p)) * 0.4;
  }
  /// Removed bone flap, as an infinite cylinder.
  template <class S>
  [[nodiscard]] S window(const Vec3<S>& p) const {
    const Vec3<S> q = p - tumour.cast<S>();
    const S along = q.dot(out.cast<S>());
    const S square = q.squaredNorm() - along * along;
    using std::sqrt;
    const S radius = sqrt(std::max(square, S(0.0)));
    return std::max(S(radius - kWindowMm), S(-along));
  }
};

void add_shells(const Head& h, Layout& layout) {
  const auto below = [h](double mm) { return [h, mm](const auto& p) { return mm - h.depth(p); }; };
  layout.add(Tissue::kSkin, below(0));
  layout.add(Tissue::kFat, below(kScalpMm));
  layout.add(Tissue::kBone, below(kSkullMm));
  layout.add(Tissue::kMarrow, below(kDiploeMm));
  layout.add(Tissue::kBone, below(kInnerTableMm));
  // The opening is filled with saline, through which the probe images.
  layout.add(Tissue::kGel, [h](const auto& p) {
    using S = ScalarOf<decltype(p)>;
    const S depth = h.depth(p);
    return std::max(h.window(p), std::max(S(depth - kDuraMm - 1), S(-0.5 - depth)));
  });
  layout.add(Tissue::kDura, below(kDuraMm));
  layout.add(Tissue::kCerebrospinalFluid, below(kFluidMm));
  layout.add(Tissue::kGreyMatter, [h](const auto& p) { return h.cortex(p); });
  layout.add(Tissue::kWhiteMatter, [h](const auto& p) { return h.white(p); });
}

void add_deep(const Head& h, Layout& layout) {
  layout.add(Tissue::kDura, [h](const auto& p) {  // Falx.
    using std::abs;
    using S = ScalarOf<decltype(p)>;
    const S rim = std::max(S(kDuraMm - h.depth(p)), S(h.depth(p) - 48));
    return std::max(S(abs(p.x()) - 0.7), std::max(rim, S(14 - p.z())));
  });
  layout.add(Tissue::kVein, [h](const auto& p) {  // Superior sagittal sinus.
    using std::hypot;
    using S = ScalarOf<decltype(p)>;
    return std::max(S(hypot(p.x(), S(h.depth(p) - 14)) - 3), S(10 - p.z()));
  });
  for (const double s : {-1.0, 1.0}) {
    layout.add(Tissue::kGreyMatter, Ellipsoid{{s * 13, 4, 2}, {9, 17, 10}});  // Thalamus.
    // Lateral ventricle: body with frontal and back horn.
    const Ellipsoid body{{s * 9, -2, 17}, {4.2, 30, 6.5}, turned(0.12, 0, s * 0.14)};
    const Ellipsoid horn{{s * 19, 34, 8}, {4, 15, 6}, turned(-0.3, 0, -s * 0.25)};
    const auto ventricle = [body, horn](const auto& p) {
      return shapes::smooth_union(body(p), horn(p), 6);
    };
    layout.add(Tissue::kCerebrospinalFluid, ventricle,
               Eigen::AlignedBox3d(Vec3d(s < 0 ? -34 : 0, -44, -6), Vec3d(s < 0 ? 0 : 34, 60, 34)));
    layout.add(Tissue::kDura, Ellipsoid{{s * 9, 6, 14}, {1.8, 8, 2.4}});  // Choroid plexus.
    const std::string side = s < 0 ? "right " : "left ";
    layout.mark(side + "frontal horn", body.centre - 0.9 * 30 * body.axes.col(1));
    layout.mark(side + "lateral ventricle", body.centre);
    // Middle cerebral artery with two branches.
    const Vec3d root(s * 8, -14, -12), bend(s * 34, -16, -4), tip(s * 46, 4, 14);
    layout.add(Tissue::kArtery, Capsule{root, bend, 1.5});
    layout.add(Tissue::kArtery, Capsule{bend, tip, 1.2});
    layout.add(Tissue::kArtery, Capsule{bend, Vec3d(s * 44, -34, 12), 1.1});
    layout.mark(side + "middle cerebral artery, fork", bend);
  }
  layout.add(Tissue::kCerebrospinalFluid, Ellipsoid{{0, 4, 0}, {1.6, 13, 9}});  // Third ventricle.
}

void add_tumour(const Head& h, Random& random, Layout& layout) {
  const Vec3d radii(random.uniform(10, 14), random.uniform(10, 15), random.uniform(9, 13));
  const Ellipsoid solid{h.tumour, radii, turned(0.3, 0.2, 0.5)};
  const Vec3d wave = random.direction() * 0.3;
  layout.add(
      Tissue::kTumour,
      [solid, wave](const auto& p) {
        using std::sin;
        using S = ScalarOf<decltype(p)>;
        return solid(p) + 0.8 * sin(wave.cast<S>().dot(p));
      },
      box_around(solid, 8));
  const Vec3d cyst = h.tumour + 0.35 * radii.x() * random.direction();
  layout.add(Tissue::kFluid, Ellipsoid{cyst, Vec3d::Constant(random.uniform(3, 4.5))});
  layout.mark("tumour", h.tumour);
  layout.mark("cyst of the tumour", cyst);
}

}  // namespace

Patient make_head(const PatientOptions& options) {
  Random random(options.seed, 0x68656164);
  const Head h(random);
  Layout layout;
  layout.box = {Vec3d(-82, -102, -94), Vec3d(82, 102, 94)};
  layout.region = {Vec3d(-80, -99, -45), Vec3d(80, 99, 91)};
  layout.cell_mm = 4;
  layout.blend = {0.6, 0.4};
  layout.skin_mm = h.scalp;
  add_shells(h, layout);
  add_deep(h, layout);
  add_tumour(h, random, layout);
  ProbeModel probe = sector_cranial();
  layout.view("through the craniotomy", probe, h.tumour, h.out, Vec3d::UnitY());
  layout.view("through the craniotomy, turned", probe, h.tumour, h.out, Vec3d::UnitZ());
  layout.place_targets(
      150, [&](const Vec3d& p) { return h.depth(p) > 18 && (p - h.tumour).norm() < 40; });
  return finish("head", options, std::move(layout));
}

}  // namespace nav::sim
