// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "registration/cost_solver.hpp"
#include "registration/image_registration.hpp"
#include "registration/similarity/similarity_cost.hpp"

namespace nav::registration {

/// Scale of rotations, mm per radian: one radian moves the edge of a sweep by about this much. With
/// rotations in this unit the condition number of the problem is near 10 instead of 10⁵.
inline constexpr double kRotationScaleMm = 60;
/// Largest movement on one level. A start that needs more is in another basin.
inline constexpr double kMaxTravelMm = 60;
/// A minimum whose cost is higher by this factor has lost: it is not followed any further.
inline constexpr double kLostRatio = 1.4;
/// Relative cost change at which an intermediate solve is finished: about 0.1 mm.
inline constexpr double kCoarseTolerance = 3e-4;

/// A pose and how it was found.
struct PoseSolution {
  Pose pose;
  double initial_cost;
  double final_cost;  ///< 1 if the cost was never finite.
  int iterations;
  int non_finite;  ///< Largest number of non-finite patches in one evaluation.
  Termination termination;
  std::string message;
  bool cancelled;
};

/// The solution whose solve ended at a pose. non_finite: see PoseSolution.
inline PoseSolution solution_at(const Pose& pose, const CostSolution& found, int non_finite) {
  return {.pose = pose,
          .initial_cost = found.initial_cost,
          .final_cost = found.final_cost,
          .iterations = found.iterations,
          .non_finite = non_finite,
          .termination = found.termination,
          .message = found.message,
          .cancelled = found.cancelled};
}

/// Levenberg–Marquardt by Ceres over a twist about the position of the sweep's centroid at the
/// start pose, so that the origins of the CT and the tracker do not matter. Ceres sees 7 residuals.
/// H = QΛQᵀ is the Gauss–Newton Hessian, softened by the secants of the steps taken, and g is the
/// gradient of E/2: the residuals [Λ^{−½}Qᵀg; √(E − gᵀH⁺g)] and the Jacobian [Λ^{½}Qᵀ; 0] have the
/// same normal equations as all samples together. keep_going: asked once per iteration; false stops
/// the solve and sets cancelled.
PoseSolution solve_pose(const SimilarityCost& cost, const Pose& start,
                        const Point<frames::Reference>& centroid, const SolveLimits& limits,
                        const std::function<bool()>& keep_going);

}  // namespace nav::registration
