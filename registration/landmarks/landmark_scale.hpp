// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "registration/landmarks/landmarks.hpp"

namespace nav::registration {

/// Axes along which one list of landmarks has a wrong scale.
enum class ScaledAxes { kAll, kCt, kReference };

/// A wrong scale of one list of landmarks: a wrong pixel size, slice spacing or unit.
struct LandmarkScale {
  ScaledAxes axes;
  /// Size of the Ct points over that of the Reference points, along x, y and z of the frame that
  /// axes names; 1 along axes that the points do not show. 0.82: the Ct points are 18 % too close
  /// together, or the Reference points too far apart.
  Eigen::Vector3d factors;
  Eigen::Vector3d sigmas;   ///< Standard errors of the factors.
  double fre_rms_mm;        ///< RMS residual with the scale removed.
  double rigid_fre_rms_mm;  ///< RMS residual of all pairs without.
  double chance;            ///< Probability of such a gain by chance (F test).
};

struct LandmarkScaleOptions {
  double least_change = 0.02;     ///< Smallest deviation of a factor from 1 that is diagnosed, > 0.
  double greatest_chance = 1e-3;  ///< Largest LandmarkScale::chance, (0, 1).
  double max_fre_rms_mm = 5;      ///< Largest residual with the scale removed, > 0.
};

/// Looks for a wrong scale by which all pairs fit much better than by a rigid motion: ct =
/// t + D·R·reference, or t + R·D·reference, with D = diag(factors), by weighted Gauss–Newton from
/// the rigid fit. The F test decides between the rigid fit, one factor for all axes, and one for
/// each; absent if the rigid fit is as good. At least 5 pairs; fewer pairs cannot tell.
/// Thread-safe, deterministic.
std::optional<LandmarkScale> landmark_scale(std::span<const LandmarkPair> pairs,
                                            const LandmarkScaleOptions& options = {});

/// "the points in the CT are 18 % too close together along x: check the pixel size or the unit",
/// with every axis that is off.
std::string in_words(const LandmarkScale& scale);

}  // namespace nav::registration
