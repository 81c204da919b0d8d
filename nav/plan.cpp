// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/plan.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

namespace nav {

Result<void> validate(const NeedlePlan& plan) {
  const auto reject = [](const std::string& what) {
    return Error{ErrorCode::kMalformedData, "needle plan: " + what};
  };
  if (!plan.entry_ct.mm.allFinite() || !plan.target_ct.mm.allFinite()) {
    return reject("expected finite entry and target, found NaN or Inf");
  }
  const double length = (plan.target_ct.mm - plan.entry_ct.mm).norm();
  if (length < 1.0) {
    std::ostringstream text;
    text << "expected entry and target at least 1 mm apart, found " << length << " mm";
    return reject(text.str());
  }
  if (!(plan.target_radius_mm >= 0 && plan.margin_mm >= 0)) {
    return reject("expected radius and margin >= 0 mm");
  }
  return {};
}

NeedleGuidance guide(const NeedlePlan& plan, const Transform<frames::Ct, frames::Needle>& needle) {
  const Point<frames::Ct> tip = needle * Point<frames::Needle>{Eigen::Vector3d::Zero()};
  const Eigen::Vector3d axis =
      (needle * Direction<frames::Needle>{Eigen::Vector3d::UnitZ()}).v.normalized();
  const Eigen::Vector3d to_target = plan.target_ct.mm - tip.mm;
  const Eigen::Vector3d path = (plan.target_ct.mm - plan.entry_ct.mm).normalized();
  NeedleGuidance guidance{};
  guidance.tip_to_target_mm = to_target.norm();
  guidance.along_axis_mm = to_target.dot(axis);
  guidance.lateral_mm = to_target.cross(axis).norm();
  guidance.angle_to_plan_rad = std::atan2(path.cross(axis).norm(), path.dot(axis));
  return guidance;
}

}  // namespace nav
