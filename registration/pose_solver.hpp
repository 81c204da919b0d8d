// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "registration/cost_solver.hpp"
#include "registration/image_registration.hpp"
#include "registration/similarity/lc2_cost.hpp"

namespace nav::registration {

/// One radian turns a sweep by about this much at its edge; with rotations in these mm the
/// problem's condition number is near 10 instead of 10⁵.
inline constexpr double kRotationScaleMm = 60;
/// A start that needs more than this from one level is in another basin.
inline constexpr double kMaxTravelMm = 60;
/// Another minimum that costs so much more has lost: it is not followed any further.
inline constexpr double kLostRatio = 1.4;
/// Share of the cost at which a solve on the way is done: some 0.1 mm.
inline constexpr double kCoarseTolerance = 3e-4;

/// A pose and how it was found.
struct PoseSolution {
  Pose pose;
  double initial_cost;
  double final_cost;  ///< 1 when the cost was never finite.
  int iterations;
  int non_finite;  ///< Most non-finite patches seen in an evaluation.
  Termination termination;
  std::string message;
  bool cancelled;
};

/// Levenberg–Marquardt by Ceres over a twist about the point that the pose gives the sweep's
/// centroid, so that neither the CT's nor the tracker's origin matters. Ceres sees 7 residuals:
/// with H = QΛQᵀ the Gauss–Newton Hessian, softened by the secants of the steps taken, and g the
/// gradient of E/2, [Λ^{−½}Qᵀg; √(E − gᵀH⁺g)] and Jacobian [Λ^{½}Qᵀ; 0] have the normal equations
/// of all samples together. keep_going: asked once per iteration; false stops with cancelled set.
PoseSolution solve_pose(const Lc2Cost& cost, const Pose& start,
                        const Point<frames::Reference>& centroid, const SolveLimits& limits,
                        const std::function<bool()>& keep_going);

}  // namespace nav::registration
