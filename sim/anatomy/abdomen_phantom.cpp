// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/abdomen_phantom.hpp"

#include <cmath>

#include "sim/anatomy/abdomen_organs.hpp"
#include "sim/anatomy/organ_stack.hpp"
#include "sim/anatomy/vessel_tree.hpp"

namespace nav::sim {
namespace {

constexpr Blend kBlend = {1.0, 0.8};
constexpr double kCellMm = 5;

NeedlePlan build_body(const Build& build, std::uint64_t seed, std::vector<Organ>& organs) {
  Random random(seed, 0x6f7267616e73);
  add_body_wall(build, organs);
  add_digestive(build, random, organs);
  add_kidneys(build, random, organs);
  add_great_vessels(organs);
  add_liver(build, organs);
  add_thorax(build, organs);
  add_spine(build, organs);
  add_ribs(build, random, organs);
  return choose_plan(build, organs, random);
}

void add_vessels(const std::vector<VesselSegment>& vessels, std::vector<Organ>& organs) {
  const auto add = [&](const VesselSegment& s, double wall_mm, Tissue tissue) {
    const shapes::Capsule c{s.from.mm, s.to.mm, s.radius_mm + wall_mm};
    const Eigen::Vector3d pad = Eigen::Vector3d::Constant(c.radius + 3);
    organs.push_back({tissue, c, {c.from.cwiseMin(c.to) - pad, c.from.cwiseMax(c.to) + pad}});
  };
  // The walls are added first, so that no wall crosses a lumen where vessels join. Only portal
  // veins have walls that ultrasound shows.
  for (const VesselSegment& s : vessels) {
    if (s.tissue == Tissue::kPortalVein) add(s, 0.5 + 0.1 * s.radius_mm, Tissue::kPortalWall);
  }
  for (const VesselSegment& s : vessels) add(s, 0, s.tissue);
}

/// Lesion: a sphere with shallow bumps that keep its centre and mean radius.
Organ lesion_organ(const NeedlePlan& plan, Random& random) {
  const Eigen::Vector3d centre = plan.target_ct.mm;
  const double radius = plan.target_radius_mm;
  const Eigen::Vector3d a = random.direction() * 0.22;
  const Eigen::Vector3d b = random.direction() * 0.27;
  const Eigen::Vector3d pad = Eigen::Vector3d::Constant(radius + 5);
  return {Tissue::kLesion,
          [=](const auto& p) {
            using std::sin;
            using S = ScalarOf<decltype(p)>;
            const Vec3<S> q = p - centre.cast<S>();
            return q.norm() - radius + 0.7 * sin(a.cast<S>().dot(q) * 1.3) +
                   0.6 * sin(b.cast<S>().dot(q));
          },
          {centre - pad, centre + pad}};
}

}  // namespace

struct AbdomenPhantom::Body {
  explicit Body(const PhantomOptions& o)
      : options(o), build(o.seed), plan(build_body(build, o.seed, organs)) {
    Random random(o.seed, 0x76657373656c73);
    organs.push_back(lesion_organ(plan, random));
    const VesselTerritory territory{[this](const Eigen::Vector3d& p) {
                                      return std::max(build.liver_mm(p),
                                                      4.0 - build.gallbladder(p));
                                    },
                                    plan};
    vessels = grow_liver_vessels(territory, random);
    add_vessels(vessels, organs);
    stack = std::make_unique<const OrganStack>(std::move(organs), anatomy_bounds(), kCellMm, kBlend,
                                               options.contrast, options.seed);
  }

  PhantomOptions options;
  Build build;
  std::vector<Organ> organs;
  NeedlePlan plan;
  std::vector<VesselSegment> vessels;
  std::unique_ptr<const OrganStack> stack;
};

AbdomenPhantom::AbdomenPhantom(const PhantomOptions& options)
    : body_(std::make_shared<const Body>(options)) {}
AbdomenPhantom::~AbdomenPhantom() = default;
AbdomenPhantom::AbdomenPhantom(const AbdomenPhantom&) = default;
AbdomenPhantom& AbdomenPhantom::operator=(const AbdomenPhantom&) = default;

const PhantomOptions& AbdomenPhantom::options() const { return body_->options; }

std::string AbdomenPhantom::name() const {
  return "phantom " + std::to_string(body_->options.seed);
}
Tissue AbdomenPhantom::tissue(const Point<frames::Ct>& p) const {
  return body_->stack->tissue(p.mm);
}
Tissue AbdomenPhantom::tissue_exhaustive(const Point<frames::Ct>& p) const {
  return body_->stack->tissue_exhaustive(p.mm);
}
double AbdomenPhantom::hu(const Point<frames::Ct>& p) const { return body_->stack->hu(p.mm); }
ValueAndGradient AbdomenPhantom::hu_with_gradient(const Point<frames::Ct>& p) const {
  return body_->stack->hu_with_gradient(p.mm);
}
Acoustics AbdomenPhantom::acoustics(const Point<frames::Ct>& p) const {
  return body_->stack->acoustics(p.mm);
}
Eigen::AlignedBox3d AbdomenPhantom::region_mm() const {
  return {Eigen::Vector3d(-150, -120, -110), Eigen::Vector3d(150, 120, 110)};
}

double AbdomenPhantom::skin_distance_mm(const Point<frames::Ct>& p) const {
  return body_->build.body(p.mm);
}
double AbdomenPhantom::liver_distance_mm(const Point<frames::Ct>& p) const {
  return body_->build.liver_mm(p.mm);
}

Point<frames::Ct> AbdomenPhantom::skin_point(double angle_rad, double z_mm) const {
  const double t = 1.0 / body_->build.body.gauge(std::cos(angle_rad), std::sin(angle_rad));
  return {{t * std::cos(angle_rad), t * std::sin(angle_rad), z_mm}};
}

const std::vector<VesselSegment>& AbdomenPhantom::vessels() const { return body_->vessels; }
NeedlePlan AbdomenPhantom::plan() const { return body_->plan; }

std::vector<NamedPoint> AbdomenPhantom::landmarks() const {
  std::vector<NamedPoint> points;
  const auto pole = [&](const char* name, const shapes::Ellipsoid& e, double side) {
    points.push_back({name, {e.centre + side * e.radii.z() * e.axes.col(2)}});
  };
  const Build& b = body_->build;
  pole("right kidney upper pole", b.right_kidney, 1);
  pole("right kidney lower pole", b.right_kidney, -1);
  pole("gallbladder fundus", b.gallbladder, -1);
  pole("gallbladder neck", b.gallbladder, 1);
  points.push_back({"lesion centre", body_->plan.target_ct});
  // A bifurcation is the end of a segment from which at least two others branch.
  std::vector<int> children(body_->vessels.size(), 0);
  for (const VesselSegment& s : body_->vessels) {
    if (s.parent >= 0) ++children[static_cast<std::size_t>(s.parent)];
  }
  constexpr int kMaxBifurcations = 12;
  int named = 0;
  for (std::size_t i = 0; i < children.size() && named < kMaxBifurcations; ++i) {
    if (children[i] < 2) continue;
    const bool portal = body_->vessels[i].tissue == Tissue::kPortalVein;
    points.push_back(
        {std::string(portal ? "portal" : "hepatic") + " bifurcation " + std::to_string(++named),
         body_->vessels[i].to});
  }
  return points;
}

std::vector<Point<frames::Ct>> AbdomenPhantom::targets() const {
  constexpr std::size_t kTargets = 200;
  constexpr double kInsideMm = 5;
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-130, -85, -75), Eigen::Vector3d(60, 75, 90));
  std::vector<Point<frames::Ct>> points;
  for (int i = 1; points.size() < kTargets; ++i) {
    const Eigen::Vector3d p = halton_in(box, i);
    if (body_->build.liver_mm(p) < -kInsideMm) points.push_back({p});
  }
  return points;
}

}  // namespace nav::sim
