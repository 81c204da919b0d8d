// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/needle_bending.hpp"

#include <cmath>
#include <numbers>

#include "nav/check.hpp"

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

Result<void> validate(const NeedleBending& b) {
  const auto refuse = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("needle bending: expected ") + what};
  };
  if (!(b.curvature_per_mm >= 0 && b.curvature_per_mm <= 0.01)) {
    return refuse("a curvature of 0 to 0.01 per mm");
  }
  if (!(b.tip_force_n >= 0 && b.tip_force_n <= 5)) return refuse("a tip force of 0 to 5 N");
  if (!(b.youngs_modulus_gpa > 0 && std::isfinite(b.youngs_modulus_gpa))) {
    return refuse("a Young's modulus > 0 GPa");
  }
  if (!(b.inner_mm >= 0 && b.outer_mm > b.inner_mm && b.outer_mm <= 10)) {
    return refuse("diameters 0 <= inner < outer <= 10 mm");
  }
  if (!std::isfinite(b.bevel_rad)) return refuse("a finite bevel direction");
  return {};
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
    // sin x / x and (1 − cos x) / x without cancellation for a needle that is nearly straight.
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
    // Past a quarter turn the tangent changes sign; a needle never gets there.
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
