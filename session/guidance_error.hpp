// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nav/plan.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

namespace nav::session {

/// Errors that are known while numbers of a needle are shown.
struct KnownErrors {
  /// Covariance of ct_from_reference; absent: not known.
  std::optional<registration::PoseUncertainty> registration{};
  /// The tracker's own figure of the error of the needle's position, RMS in mm, with the
  /// reference's if that is tracked; absent: the tracker gives none.
  std::optional<double> tracker_rms_mm{};
};

/// Half widths of intervals that hold the true number with 95 %, for the errors that are known.
/// Absent numbers: nothing is known about them.
struct GuidanceError {
  std::optional<double> tip_to_target_mm{}, along_axis_mm{}, lateral_mm{}, angle_to_plan_rad{};
  /// Half width for the tip's position, in the direction in which it is largest.
  std::optional<double> tip_mm{};
  std::vector<std::string> with{};     ///< Errors that are in it.
  std::vector<std::string> without{};  ///< Errors that are not in it.
};

/// Propagates the known errors to the numbers, to first order, for normally distributed errors. A
/// distance that is smaller than its own error has no direction: there the largest error of all
/// directions counts. The tracker's figure counts for the position of the tip; the error of the
/// needle's direction, its calibration, its bending and the motion of the organ are not known, and
/// are not in it.
GuidanceError guidance_error(const NeedlePlan& plan,
                             const Transform<frames::Ct, frames::Needle>& needle,
                             const KnownErrors& known);

}  // namespace nav::session
