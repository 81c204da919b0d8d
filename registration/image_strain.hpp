// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "registration/pose_solver.hpp"

namespace nav::registration {

/// Patches with their centres moved by a strain; each patch stays a rigid piece of its ultrasound
/// image.
PatchSet strained(const PatchSet& patches, const ImageScale& strain);

/// A pose with the strain that was refined with it.
struct StrainSolution {
  PoseSolution pose;  ///< Its costs are those of the moved patches.
  ImageScale stretch;
};

/// Refines the pose together with a strain: Ceres over [60 ω | t | six strains] about the sweep's
/// centroid, all in mm at 60 mm. The derivatives are exact for patches that move as rigid pieces;
/// the deformation within a patch of a centimetre (0.2 mm at 4 %) is neglected. Each strain stays
/// within 10 %. Precondition: the similarity is kLc2 or kNcc.
StrainSolution solve_strain(const SimilarityCost& cost, const Pose& start,
                            const Point<frames::Reference>& centroid, const SolveLimits& limits,
                            const std::function<bool()>& keep_going);

}  // namespace nav::registration
