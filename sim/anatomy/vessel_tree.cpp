// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/vessel_tree.hpp"

#include <cmath>
#include <deque>
#include <optional>

#include "sim/shapes.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using shapes::Capsule;

constexpr double kMinRadiusMm = 1.3;
constexpr double kLargeRadiusMm = 2.0;
constexpr double kPathClearanceMm = 5.0;
constexpr std::size_t kMaxSegments = 260;

struct Bud {
  int parent;
  Vec from;
  Vec direction;
  double radius_mm;
  Tissue tissue;
};

class Grower {
 public:
  Grower(const VesselTerritory& territory, Random& random)
      : territory_(territory), random_(random) {}

  int force(int parent, const Vec& from, const Vec& to, double radius_mm, Tissue tissue) {
    segments_.push_back(
        {.from = {from}, .to = {to}, .radius_mm = radius_mm, .tissue = tissue, .parent = parent});
    return static_cast<int>(segments_.size()) - 1;
  }

  void bud(int parent, const Vec& direction, double radius_mm) {
    const VesselSegment& s = segments_[static_cast<std::size_t>(parent)];
    buds_.push_back({.parent = parent,
                     .from = s.to.mm,
                     .direction = direction.normalized(),
                     .radius_mm = radius_mm,
                     .tissue = s.tissue});
  }

  void grow() {
    while (!buds_.empty() && segments_.size() < kMaxSegments) {
      const Bud next = buds_.front();
      buds_.pop_front();
      grow(next);
    }
  }

  std::vector<VesselSegment> take() { return std::move(segments_); }

 private:
  void grow(const Bud& bud) {
    const auto best = best_piece(bud);
    if (!best) return;
    const int piece = force(bud.parent, bud.from, *best, bud.radius_mm, bud.tissue);
    const Vec along = (*best - bud.from).normalized();
    const double share = random_.uniform(0.55, 0.8);  // Share of the cubed radius.
    const double large = bud.radius_mm * std::cbrt(share);
    const double small = bud.radius_mm * std::cbrt(1 - share);
    const Vec side = along.cross(random_.direction()).normalized();
    if (large >= kMinRadiusMm) this->bud(piece, along + 0.35 * side, large);
    if (small >= kMinRadiusMm) this->bud(piece, along - 0.9 * side, small);
  }

  /// End of the next piece: among several directions the one that leads into the largest free
  /// space.
  std::optional<Vec> best_piece(const Bud& bud) {
    std::optional<Vec> best;
    double best_score = 0;
    constexpr int kTries = 14;
    for (int i = 0; i < kTries; ++i) {
      const Vec direction = (bud.direction + (0.25 + 0.05 * i) * random_.direction()).normalized();
      const double length =
          std::clamp(bud.radius_mm * random_.uniform(4.0, 6.5), 9.0, 26.0) * (1.0 - 0.03 * i);
      const Capsule piece{bud.from, bud.from + length * direction, bud.radius_mm};
      const double free_mm = free_space(piece, bud.parent);
      if (free_mm <= 0) continue;
      const double score = std::min(free_mm, 12.0) + 4.0 * direction.dot(bud.direction);
      if (!best || score > best_score) {
        best = piece.to;
        best_score = score;
      }
    }
    return best;
  }

  /// Free space around a piece beyond its need, mm; not positive: it does not fit.
  [[nodiscard]] double free_space(const Capsule& piece, int parent) const {
    double room = -territory_.liver_mm(piece.to) - (piece.radius + 3);
    if (room <= 0) return room;
    const NeedlePlan& plan = territory_.plan;
    room = std::min(
        room, piece.axis_distance(plan.target_ct.mm) - piece.radius - plan.target_radius_mm - 1.5);
    if (piece.radius > kLargeRadiusMm) {
      const Capsule path{plan.entry_ct.mm, plan.target_ct.mm, kPathClearanceMm};
      room = std::min(room, axis_gap(piece, path) - piece.radius - path.radius);
    }
    for (std::size_t i = 0; i < segments_.size() && room > 0; ++i) {
      const VesselSegment& s = segments_[i];
      const bool kin = static_cast<int>(i) == parent || s.parent == parent;
      if (kin) continue;
      const double gap = axis_gap(piece, Capsule{s.from.mm, s.to.mm, s.radius_mm});
      room = std::min(room, gap - piece.radius - s.radius_mm - 1.5);
    }
    return room;
  }

  const VesselTerritory& territory_;
  Random& random_;
  std::vector<VesselSegment> segments_;
  std::deque<Bud> buds_;  // First in, first out: large vessels occupy their space first.
};

}  // namespace

std::vector<VesselSegment> grow_liver_vessels(const VesselTerritory& territory, Random& random) {
  Grower grower(territory, random);
  const Vec hilum = Vec(-28, 2, 4) + random.offset(3);
  const int portal = grower.force(-1, {-4, 14, -22}, hilum, 6.5, Tissue::kPortalVein);
  grower.bud(portal, Vec(-1, 0.1, -0.05) + random.offset(0.15), 5.4);
  grower.bud(portal, Vec(0.45, -0.9, 0.45) + random.offset(0.15), 4.6);
  const Vec cava(-21, 21, 66);
  const Vec ways[] = {{-1, -0.15, -0.5}, {-0.45, -0.9, -0.35}, {0.5, -0.95, -0.2}};
  for (const Vec& way : ways) {
    const Vec direction = (way + random.offset(0.12)).normalized();
    const int trunk = grower.force(-1, cava + 6 * direction, cava + 20 * direction,
                                   random.uniform(4.2, 5.2), Tissue::kHepaticVein);
    grower.bud(trunk, direction + Vec(0, 0, -0.2), 4.4);
  }
  grower.grow();
  return grower.take();
}

}  // namespace nav::sim
