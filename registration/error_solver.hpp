// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "registration/image_errors.hpp"
#include "registration/motion/image_motion.hpp"
#include "registration/pose_solver.hpp"
#include "registration/similarity/patches.hpp"

namespace nav::registration {

/// Motion of the probe during a sweep, from all its recorded images.
using ProbePath = std::span<const ImageMotion>;

/// The patches of a sweep without its errors: each image is scaled, moved on the probe, and moved
/// along the path of the probe by the delay. motions: of the images that the patches belong to.
PatchSet corrected(const PatchSet& patches, const ImageErrors& errors,
                   std::span<const ImageMotion> motions, ProbePath path);

/// Twist [rad | mm] of each patch, about its corrected centre and in Reference, by each value of
/// ImageErrors::vector().
std::vector<Eigen::Matrix<double, 6, kErrorParameters>> twists_by_errors(
    const PatchSet& patches, const ImageErrors& errors, std::span<const ImageMotion> motions,
    ProbePath path);

/// A pose with the errors that were refined with it.
struct ErrorSolution {
  PoseSolution pose;  ///< Its costs are those of the corrected patches.
  ImageErrors errors;
};

/// Refines pose and errors together, as solve_pose() does for the pose alone. The errors have the
/// prior \p sigmas, weighed as the scatter of the patches' gradients over cubes of 20 mm asks for:
/// an error that the sweep does not show stays at 0. Precondition: the similarity has terms of
/// single patches.
ErrorSolution solve_errors(const SimilarityCost& cost, const Pose& start, const ImageErrors& errors,
                           const Point<frames::Reference>& centroid, const ErrorSigmas& sigmas,
                           std::span<const ImageMotion> motions, ProbePath path,
                           const SolveLimits& limits, const std::function<bool()>& keep_going);

}  // namespace nav::registration
