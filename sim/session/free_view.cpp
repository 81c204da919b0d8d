// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/session/free_view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "sim/motion/skin_track.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

Vec centre_of(const std::vector<Point<frames::Ct>>& points) {
  Vec sum = Vec::Zero();
  for (const auto& p : points) sum += p.mm;
  return sum / static_cast<double>(points.size());
}

/// Point where a ray leaves the patient.
std::optional<Vec> skin_along(const Anatomy& patient, const Vec& from, const Vec& direction) {
  constexpr double kStepMm = 1;
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i) {
    const Vec p = from + i * kStepMm * direction;
    if (patient.skin_distance_mm({p}) >= 0) return p;
  }
  return std::nullopt;
}

/// Blocked share of a fan of lines from the skin towards the targets.
double blocked_share(const Anatomy& patient, const Vec& skin, const Vec& target, const Vec& side) {
  int blocked = 0, all = 0;
  for (int line = -4; line <= 4; ++line) {
    const Vec to = target + 12.0 * line * side - skin;
    bool hit = false;
    for (double t = 0.05; t <= 1; t += 0.02) {
      hit = hit || blocks_ultrasound(patient.tissue({skin + 4.0 * line * side + t * to}));
      blocked += hit ? 1 : 0;
      ++all;
    }
  }
  return static_cast<double>(blocked) / all;
}

Transform<frames::Ct, frames::Image> looking(const Vec& skin, const Vec& into, double press_mm) {
  Eigen::Matrix3d axes;
  axes.col(1) = into;
  axes.col(0) = into.cross(Vec::UnitZ()).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return {Eigen::Quaterniond(axes).normalized(), skin + press_mm * into};
}

double lean_rad(const Anatomy& patient, const Vec& skin, const Vec& into) {
  constexpr double kFootprintMm = 15;  // Footprint of a probe.
  return std::acos(std::clamp(-into.dot(outward(patient, skin, kFootprintMm)), -1.0, 1.0));
}

}  // namespace

double press_mm(ProbeKind probe) { return probe == ProbeKind::kConvex ? 8 : 2; }

std::optional<Transform<frames::Ct, frames::Image>> settled(
    const Anatomy& patient, const Transform<frames::Ct, frames::Image>& view, double press_mm) {
  constexpr double kBackMm = 20;
  const Vec into = view.rotation() * Vec::UnitY();
  // Ray from inside, outwards along the beam.
  const auto skin = skin_along(patient, view.translation_mm() + kBackMm * into, -into);
  if (!skin || lean_rad(patient, *skin, into) > kMostLeanRad) return std::nullopt;
  return Transform<frames::Ct, frames::Image>(view.rotation(), *skin + press_mm * into);
}

Result<Transform<frames::Ct, frames::Image>> free_view(const Anatomy& patient, double press_mm) {
  const auto targets = patient.targets();
  const Error none{ErrorCode::kUsage,
                   "simulated patient: expected skin around targets, found none"};
  if (targets.empty()) return none;
  const Vec centre = centre_of(targets);
  double best = 1e9;
  std::optional<Transform<frames::Ct, frames::Image>> view;
  constexpr double kTurn = 2 * std::numbers::pi;
  for (int i = 0; i < 24; ++i) {
    for (const double up : {-0.6, -0.3, 0.0, 0.3}) {
      const double turn = kTurn * i / 24;
      const Vec out(std::cos(turn) * std::cos(up), std::sin(turn) * std::cos(up), std::sin(up));
      const auto skin = skin_along(patient, centre, out);
      if (!skin) continue;
      const Vec side = out.cross(Vec::UnitZ()).normalized();
      // The score prefers free lines, then a pose that can be held, then the shortest path.
      const double too_far = std::max(lean_rad(patient, *skin, -out) - kMostLeanRad, 0.0);
      const double score =
          blocked_share(patient, *skin, centre, side) + too_far + 2e-4 * (*skin - centre).norm();
      if (score >= best) continue;
      best = score;
      view = looking(*skin, -out, press_mm);
    }
  }
  if (!view) return none;
  return *view;
}

}  // namespace nav::sim
