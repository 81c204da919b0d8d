// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "registration/acceptance.hpp"
#include "registration/shape/shape_registration.hpp"

namespace nav::registration {

/// Limits that a registration to a shape must meet. Inclusive.
struct ShapeLimits {
  double max_mean_mm = 3;     ///< Mean distance of all points, > 0.
  double max_tre_rms_mm = 2;  ///< Predicted error at the target, > 0.
  /// Residuals that neighbouring points share, as a multiple of the expected noise, > 0.
  double max_shared = 1.3;
  /// Log-likelihood by which every rival must explain independent points worse.
  double min_evidence = 12;
  /// Stretch of the shape that explains the points better, > 0, if it is beyond chance.
  double max_stretch = 0.01;
  /// Log-likelihood that a strain of six parameters may gain by chance. Twice this value is a
  /// chi-squared of six degrees of freedom: 7.5 is passed once in 50 times.
  double max_strain_evidence = 7.5;
  double max_scale_sigmas = 3;  ///< Limit of a stretch that is equal in all directions.
  /// A size that is known less well than both of these is not shown by the points: a bone of
  /// another level would fit as well.
  double max_scale_sigma = 0.01;
  double max_moved_sigma_mm = 1;
  double max_shared_distance_mm = 1.5;  ///< Distance of all points from the surface, if known.
};
inline constexpr ShapeLimits kShapeWarnings{.max_mean_mm = 2.5, .max_tre_rms_mm = 1};

/// Knowledge about the pose without the shape: landmarks, or a start that the user vouches for.
struct KnownPose {
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  double within_mm;  ///< The points lie within this distance (RMS) of where the pose puts them.
  /// It tells left from right: landmarks that lie in no plane, of a CT that is not mirrored.
  bool tells_sides;
};

/// Judges a result for use at a target. A value that is not finite never passes; every sliding
/// direction is a reason for rejection and is named. A rival that explains the points nearly as
/// well is a reason unless what is known rules it out. given_sigma_mm: standard deviation of the
/// points' errors as the user gives it; without it the noise comes from the residuals.
Decision decide(const ShapeRegistration& result, const ShapeLimits& limits,
                const Point<frames::Ct>& target, const ShapeLimits& warnings = kShapeWarnings,
                const std::optional<KnownPose>& known = {},
                const std::optional<double>& given_sigma_mm = {});

}  // namespace nav::registration
