// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "render/features/run.hpp"
#include "render/features/scan_lines.hpp"
#include "render/features/volume.hpp"

namespace nav::render::features {

/// Default smoothing of the gradients of predicates, mm.
inline constexpr double kUsualSmoothingMm = 0.4;

struct GradientOptions {
  /// Gaussian smoothing before the derivative ("the smoothed gradient", Schulte zu Berge et al.
  /// 2014, §3.1), mm, [0, 20]; 0: central differences of the voxels themselves.
  double smoothing_mm = 0;
  /// Radius of the smoothing filters in sigmas, [2, 8].
  double truncate = 4;
  /// Least magnitude, per mm, > 0. A smaller gradient has no direction, and its angle is NaN.
  double least_per_mm = 1e-3;
};
Result<void> validate(const GradientOptions& options);
/// Also rejects smoothing that would reach hundreds of voxels of a grid. \p name: name of the
/// volume.
Result<void> validate(const GradientOptions& options, const VoxelGrid& grid,
                      const std::string& name);

/// Gradient at a voxel by central differences, per mm, in the frame of the volume. Differences are
/// one-sided at borders and beside unknown voxels, and 0 along an axis with one voxel. NaN at
/// unknown voxels, and if an axis has no known neighbour.
Eigen::Vector3d gradient_at(const ScalarVolume& volume, int i, int j, int k);

/// Angle between two vectors, rad, [0, pi]: atan2(|g x s|, g . s). It is exact near 0 and pi, and
/// for unit vectors that rounding made longer than 1. NaN when |g| < least or a component is NaN.
double gradient_angle(const Eigen::Vector3d& gradient, const Eigen::Vector3d& away, double least);

/// A part of the gradient. All parts except the magnitude need scan lines and are NaN where these
/// are undefined.
enum class GradientPart {
  kMagnitude,  ///< Per mm.
  kAngle,      ///< Angle to the scan line away from the transducer, rad, [0, pi].
  kAlong,      ///< Derivative along that line, per mm: > 0 if brightness increases with depth.
  kAcross,     ///< Magnitude of the remaining component, per mm.
};
/// Computes a part of the gradient; NaN where the gradient is NaN. \p lines: may be null for the
/// magnitude. Takes 4 bytes per voxel, and 10 more with smoothing (borders and unknown voxels are
/// then treated as in FilledField). Rejects a part without the lines that it needs, and smoothing
/// that reaches more than 256 voxels.
Result<FeatureVolume> gradient_part(const ScalarVolume& volume, GradientPart part,
                                    const ScanLines* lines, const GradientOptions& options = {},
                                    const RunOptions& run = {});

}  // namespace nav::render::features
