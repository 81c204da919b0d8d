// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "render/features/run.hpp"
#include "render/features/scan_lines.hpp"
#include "render/features/volume.hpp"

namespace nav::render::features {

/// What predicates' gradients are smoothed by unless told otherwise, mm.
inline constexpr double kUsualSmoothingMm = 0.4;

struct GradientOptions {
  /// Gaussian smoothing before ("the smoothed gradient", Schulte zu Berge et al. 2014, §3.1), mm,
  /// [0, 20]; 0: central differences of the voxels themselves.
  double smoothing_mm = 0;
  /// Radius of the smoothing filters in sigmas, [2, 8].
  double truncate = 4;
  /// Below this magnitude a gradient has no direction and its angle is NaN, per mm, > 0.
  double least_per_mm = 1e-3;
};
Result<void> validate(const GradientOptions& options);
/// Also smoothing that would reach hundreds of voxels of a grid. name: of the volume.
Result<void> validate(const GradientOptions& options, const VoxelGrid& grid,
                      const std::string& name);

/// Gradient at a voxel by central differences, per mm, in the frame of the volume; one-sided at
/// borders and beside unknown voxels; 0 along an axis of one voxel. NaN at unknown voxels and where
/// an axis has no known neighbour.
Eigen::Vector3d gradient_at(const ScalarVolume& volume, int i, int j, int k);

/// Angle between two vectors, rad, [0, pi]: atan2(|g x s|, g . s), exact near 0 and pi and for unit
/// vectors that rounding made longer than 1. NaN when |g| < least or any part is NaN.
double gradient_angle(const Eigen::Vector3d& gradient, const Eigen::Vector3d& away, double least);

/// What of a gradient; all but its magnitude need scan lines and are NaN where they are undefined.
enum class GradientPart {
  kMagnitude,  ///< Per mm.
  kAngle,      ///< To the scan line away from the transducer, rad, [0, pi].
  kAlong,      ///< Derivative along that line, per mm: > 0 where it gets brighter with depth.
  kAcross,     ///< Size of the rest, per mm.
};
/// NaN where the gradient is. lines: may be null for the magnitude. Holds 4 bytes per voxel, and 10
/// more with smoothing (borders and unknown voxels then as in FilledField). Refuses a part without
/// the lines that it needs, and smoothing that reaches more than 256 voxels.
Result<FeatureVolume> gradient_part(const ScalarVolume& volume, GradientPart part,
                                    const ScanLines* lines, const GradientOptions& options = {},
                                    const RunOptions& run = {});

}  // namespace nav::render::features
