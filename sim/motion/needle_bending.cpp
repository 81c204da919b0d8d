// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/needle_bending.hpp"

#include <cmath>
#include <numbers>
#include <sstream>

#include "nav/check.hpp"
#include "sim/named_kind.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

/// Flexural rigidity of a tube, N mm².
double rigidity(const NeedleBending& b) {
  const double inertia_mm4 =
      std::numbers::pi * (std::pow(b.outer_mm, 4) - std::pow(b.inner_mm, 4)) / 64;
  return 1e3 * b.youngs_modulus_gpa * inertia_mm4;
}

}  // namespace

const char* to_string(BendingKind kind) {
  switch (kind) {
    case BendingKind::kStraight:
      return "straight";
    case BendingKind::kBevelArc:
      return "bevel";
    case BendingKind::kTipLoad:
      return "tip-load";
  }
  return "unknown";
}

Result<BendingKind> bending_kind_from(std::string_view name) {
  return kind_by_name(
      "needle", {BendingKind::kStraight, BendingKind::kBevelArc, BendingKind::kTipLoad}, name);
}

Result<void> validate(const NeedleBending& b) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("needle bending: expected ") + what};
  };
  if (!(b.curvature_per_mm >= 0 && b.curvature_per_mm <= 0.01)) {
    return reject("a curvature of 0 to 0.01 per mm");
  }
  if (!(b.tip_force_n >= 0 && b.tip_force_n <= 5)) return reject("a tip force of 0 to 5 N");
  if (!(b.youngs_modulus_gpa > 0 && std::isfinite(b.youngs_modulus_gpa))) {
    return reject("a Young's modulus > 0 GPa");
  }
  if (!(b.inner_mm >= 0 && b.outer_mm > b.inner_mm && b.outer_mm <= 10)) {
    return reject("diameters 0 <= inner < outer <= 10 mm");
  }
  if (!std::isfinite(b.bevel_rad)) return reject("a finite bevel direction");
  return {};
}

Result<NeedleBending> bending_aside(const NeedleBending& bending, double path_mm, double aside_mm) {
  if (const auto ok = validate(bending); !ok) return ok.error();
  if (!(path_mm > 0 && path_mm <= 1000)) {
    return Error{ErrorCode::kUsage, "needle bending: expected a path of 0 to 1000 mm, found " +
                                        std::to_string(path_mm)};
  }
  if (!(aside_mm >= 0 && aside_mm <= kMostAsideShare * path_mm)) {
    std::ostringstream text;
    text << "needle bending: expected a sideways distance of 0 to " << kMostAsideShare * path_mm
         << " mm (a fifth of the path), found " << aside_mm << " mm";
    return Error{ErrorCode::kUsage, text.str()};
  }
  NeedleBending out = bending;
  // The tip of an arc lies on a chord that leaves the axis at half the turn. Its deflection s = L²
  // k / 2 · sinc²(k L / 2) has no closed inverse, but increases with k in this range.
  double low = 0, high = 1.0 / path_mm;
  for (int i = 0; i < 60 && bending.kind == BendingKind::kBevelArc; ++i) {
    const double middle = 0.5 * (low + high);
    const double half = 0.5 * middle * path_mm;
    const double sinc = half < 1e-4 ? 1 - half * half / 6 : std::sin(half) / half;
    (path_mm * half * sinc * sinc < aside_mm ? low : high) = middle;
  }
  if (bending.kind == BendingKind::kBevelArc) out.curvature_per_mm = aside_mm > 0 ? high : 0;
  if (bending.kind == BendingKind::kTipLoad) {
    out.tip_force_n = 3 * rigidity(bending) * aside_mm / std::pow(path_mm, 3);
  }
  if (const auto ok = validate(out); !ok) return ok.error();
  return out;
}

BentNeedle::BentNeedle(const NeedleBending& bending, double inserted_mm)
    : bending_(bending), inserted_mm_(inserted_mm), rigidity_n_mm2_(rigidity(bending)) {
  NAV_CHECK(validate(bending).has_value());
  NAV_CHECK(inserted_mm >= 0 && inserted_mm <= 1000, inserted_mm);
}

Point<frames::Needle> BentNeedle::at(double arc_mm) const {
  NAV_CHECK(arc_mm >= 0 && arc_mm <= inserted_mm_, arc_mm, inserted_mm_);
  double aside = 0;
  double along = arc_mm;
  if (bending_.kind == BendingKind::kBevelArc) {
    const double turn = bending_.curvature_per_mm * arc_mm;
    // Computes sin x / x and (1 − cos x) / x without cancellation for a nearly straight needle.
    const double half = 0.5 * turn;
    const double sinc = half < 1e-4 ? 1 - half * half / 6 : std::sin(half) / half;
    aside = arc_mm * half * sinc * sinc;
    along = arc_mm * sinc * std::cos(half);
  } else if (bending_.kind == BendingKind::kTipLoad) {
    aside = bending_.tip_force_n * arc_mm * arc_mm * (3 * inserted_mm_ - arc_mm) /
            (6 * rigidity_n_mm2_);
  }
  return {Vec(aside * std::cos(bending_.bevel_rad), aside * std::sin(bending_.bevel_rad),
              along - inserted_mm_)};
}

Direction<frames::Needle> BentNeedle::direction(double arc_mm) const {
  double slope = 0;
  if (bending_.kind == BendingKind::kBevelArc) {
    slope = std::tan(bending_.curvature_per_mm * arc_mm);
    // Beyond a quarter turn the tangent changes its sign; a needle does not reach it.
    NAV_CHECK(bending_.curvature_per_mm * arc_mm < 1.5, arc_mm);
  } else if (bending_.kind == BendingKind::kTipLoad) {
    slope = bending_.tip_force_n * arc_mm * (2 * inserted_mm_ - arc_mm) / (2 * rigidity_n_mm2_);
  }
  return {Vec(slope * std::cos(bending_.bevel_rad), slope * std::sin(bending_.bevel_rad), 1)
              .normalized()};
}

std::vector<Point<frames::Needle>> BentNeedle::shaft(int points) const {
  NAV_CHECK(points >= 2, points);
  std::vector<Point<frames::Needle>> shape;
  for (int i = 0; i < points; ++i) shape.push_back(at(inserted_mm_ * i / (points - 1)));
  return shape;
}

}  // namespace nav::sim
