// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "nav/transform.hpp"

namespace nav {

/// A planned straight needle path in the CT.
struct NeedlePlan {
  Point<frames::Ct> entry_ct;   ///< Point on the skin.
  Point<frames::Ct> target_ct;  ///< Centre of the lesion.
  double target_radius_mm = 0;  ///< Lesion as a sphere, >= 0.
  double margin_mm = 0;         ///< Safety or ablation margin beyond the radius, >= 0.
};

/// Rejects non-finite points, an entry within 1 mm of the target, and negative radii.
Result<void> validate(const NeedlePlan& plan);

/// Position and direction of the needle with respect to the plan.
struct NeedleGuidance {
  double tip_to_target_mm;   ///< Straight distance from the tip to the target.
  double along_axis_mm;      ///< Distance still to advance along its axis; negative: past.
  double lateral_mm;         ///< Distance between the needle axis and the target.
  double angle_to_plan_rad;  ///< Angle between the needle axis and the planned path.
};

/// Computes the guidance by geometry alone. The caller ensures that every input is valid.
NeedleGuidance guide(const NeedlePlan& plan, const Transform<frames::Ct, frames::Needle>& needle);

}  // namespace nav
