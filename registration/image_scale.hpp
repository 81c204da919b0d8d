// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "registration/pose_solver.hpp"

namespace nav::registration {

/// Patches with their centres moved by a depth factor or strain; each patch stays a rigid piece of
/// its ultrasound image.
PatchSet stretched(const PatchSet& patches, const ImageScale& stretch);

/// A pose with the depth factor or strain that was refined with it.
struct ScaleSolution {
  PoseSolution pose;  ///< Its costs are those of the moved patches.
  ImageScale stretch;
};

/// Refines the pose together with the depth factor or strain: Ceres over [60 ω | t | parameters]
/// about the sweep's centroid, all in mm at 60 mm. The derivatives are exact for patches that move
/// as rigid pieces; the deformation within a patch of a centimetre (0.2 mm at 4 %) is neglected.
/// Each parameter stays within 10 %. Preconditions: model is not kNone; the similarity is kLc2 or
/// kNcc.
ScaleSolution solve_scale(const Lc2Cost& cost, const Pose& start,
                          const Point<frames::Reference>& centroid, ScaleModel model,
                          const SolveLimits& limits, const std::function<bool()>& keep_going);

}  // namespace nav::registration
