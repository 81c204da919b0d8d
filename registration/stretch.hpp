// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "registration/pose_solver.hpp"

namespace nav::registration {

/// Patches whose centres a stretch has moved; each stays a rigid piece of its picture.
PatchSet stretched(const PatchSet& patches, const Stretch& stretch);

/// A pose with the stretch that goes with it.
struct StretchSolution {
  PoseSolution pose;  ///< Its costs are those of the stretched patches.
  Stretch stretch;
};

/// Refines pose and stretch together: Ceres over [60 ω | t | stretch] about the sweep's centroid,
/// all in mm at 60 mm. The derivatives are exact for patches that move as rigid pieces; what a
/// patch of a centimetre is stretched itself (0.2 mm at 4 %) is left out. Stays within 10 % of each
/// strain. Preconditions: model is not kNone; the similarity is kLc2 or kNcc.
StretchSolution solve_stretch(const Lc2Cost& cost, const Pose& start,
                              const Point<frames::Reference>& centroid, StretchModel model,
                              const SolveLimits& limits, const std::function<bool()>& keep_going);

}  // namespace nav::registration
