// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <numbers>
#include <optional>

#include "nav/check.hpp"
#include "sim/anatomy/abdomen_organs.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kLesionRadiusMm = 12;
constexpr double kMarginMm = 5;
constexpr double kMinPathMm = 45;
constexpr double kMaxPathMm = 105;

/// Least distance of a needle from an organ, mm; absent: it may pass through.
std::optional<double> clearance_mm(Tissue tissue) {
  switch (tissue) {
    case Tissue::kBone:
    case Tissue::kCartilage:
      return 5.0;
    case Tissue::kLung:
    case Tissue::kBile:
    case Tissue::kKidneyCortex:
    case Tissue::kBowelWall:
    case Tissue::kVenaCava:
    case Tissue::kAorta:
      return 6.0;
    default:
      return std::nullopt;
  }
}

/// Smallest remaining clearance along the path, mm; negative: it touches an organ.
double spare_mm(const std::vector<Organ>& organs, const Vec& entry, const Vec& target) {
  double spare = 1e9;
  Eigen::AlignedBox3d path(entry.cwiseMin(target), entry.cwiseMax(target));
  path.min().array() -= 15;
  path.max().array() += 15;
  const int steps = static_cast<int>((target - entry).norm() / 1.5) + 1;
  for (const Organ& organ : organs) {
    const auto keep = clearance_mm(organ.tissue);
    if (!keep || !organ.bounds.intersects(path)) continue;
    for (int i = 0; i <= steps; ++i) {
      const Vec p = entry + (target - entry) * (static_cast<double>(i) / steps);
      spare = std::min(spare, organ.distance_mm(p) - *keep);
      if (spare < 0) return spare;
    }
  }
  return spare;
}

struct Path {
  Vec entry;
  double score;
};

std::optional<Path> best_entry(const Build& build, const std::vector<Organ>& organs,
                               const Vec& target) {
  std::optional<Path> best;
  for (double angle = std::numbers::pi * 0.95; angle < 4.6; angle += 0.1) {
    for (double z = -50; z <= 60; z += 5) {
      const double t = 1.0 / build.body.gauge(std::cos(angle), std::sin(angle));
      const Vec entry(t * std::cos(angle), t * std::sin(angle), z);
      const double length = (target - entry).norm();
      if (length < kMinPathMm || length > kMaxPathMm) continue;
      // A needle slides off the skin at a grazing angle.
      const Vec inward = Vec(-entry.x(), -entry.y(), 0).normalized();
      if (inward.dot(target - entry) < 0.6 * length) continue;
      const double spare = spare_mm(organs, entry, target);
      if (spare < 0) continue;
      const double score = std::min(spare, 6.0) - 0.05 * length;
      if (!best || score > best->score) best = Path{entry, score};
    }
  }
  return best;
}

}  // namespace

NeedlePlan choose_plan(const Build& build, const std::vector<Organ>& organs, Random& random) {
  const Eigen::AlignedBox3d region(Vec(-100, -50, -25), Vec(-45, 30, 45));
  const int start = static_cast<int>(random.uniform(1, 4000));
  constexpr int kTries = 400;
  for (int i = 0; i < kTries; ++i) {
    const Vec target = halton_in(region, start + i);
    if (build.liver_mm(target) > -(kLesionRadiusMm + 7)) continue;
    if (build.gallbladder(target) < kLesionRadiusMm + 8) continue;
    // The trunks of the vessel trees enter here.
    if ((target - Vec(-28, 2, 4)).norm() < 34 || (target - Vec(-24, 18, 62)).norm() < 36) continue;
    if (const auto path = best_entry(build, organs, target)) {
      return {{path->entry}, {target}, kLesionRadiusMm, kMarginMm};
    }
  }
  NAV_CHECK(false, "no lesion with a free path");
  return {};
}

}  // namespace nav::sim
