// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/outside_ct.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "nav/check.hpp"

namespace nav::session {

double mm_outside(const Volume& ct, std::span<const Point<frames::Ct>> points) {
  NAV_CHECK(!points.empty(), points.size());
  const VoxelGrid& grid = ct.grid();
  Eigen::AlignedBox3d box;
  for (const auto& p : points) box.extend(grid.directions.transpose() * (p.mm - grid.centre().mm));
  const Eigen::Vector3d reach = 0.5 * grid.extent_mm();
  return std::sqrt(box.squaredExteriorDistance(Eigen::AlignedBox3d(-reach, reach)));
}

void warn_outside(const std::string& name, std::span<const Point<frames::Ct>> points,
                  double slack_mm, const Volume& ct, Diagnostics& diagnostics) {
  const double outside_mm = mm_outside(ct, points);
  if (!(outside_mm > slack_mm)) return;
  diagnostics.report(Severity::kWarning, name,
                     "it lies " + std::to_string(std::lround(std::ceil(outside_mm))) +
                         " mm outside of the CT: is it in the CT's frame, LPS, mm?");
}

void warn_outside(const NeedlePlan& plan, const Volume& ct, Diagnostics& diagnostics) {
  constexpr double kSkinMm = 50;
  warn_outside("plan.target_mm", std::array{plan.target_ct}, plan.target_radius_mm, ct,
               diagnostics);
  warn_outside("plan.entry_mm", std::array{plan.entry_ct}, kSkinMm, ct, diagnostics);
}

}  // namespace nav::session
