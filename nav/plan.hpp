// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "nav/transform.hpp"

namespace nav {

/// A planned straight needle path in the CT.
struct NeedlePlan {
  Point<frames::Ct> entry_ct;   ///< On the skin.
  Point<frames::Ct> target_ct;  ///< Centre of the lesion.
  double target_radius_mm = 0;  ///< Lesion as a sphere, >= 0.
  double margin_mm = 0;         ///< Safety or ablation margin beyond the radius, >= 0.
};

/// Refuses non-finite points, an entry within 1 mm of the target, negative radii.
Result<void> validate(const NeedlePlan& plan);

/// Where the needle is with respect to the plan.
struct NeedleGuidance {
  double tip_to_target_mm;   ///< Straight distance.
  double along_axis_mm;      ///< Still to advance along the needle's own axis; negative: past.
  double lateral_mm;         ///< How far the needle's axis passes beside the target.
  double angle_to_plan_rad;  ///< Between the needle's axis and the planned path.
};

/// Pure geometry; exists only while every input is valid, which the caller decides.
NeedleGuidance guide(const NeedlePlan& plan, const Transform<frames::Ct, frames::Needle>& needle);

}  // namespace nav
