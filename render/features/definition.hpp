// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>

#include "render/features/gradient.hpp"
#include "render/features/snr.hpp"
#include "render/features/vesselness.hpp"

/// What the derived volumes are, in double precision and without a thought for speed: the judges of
/// the fast implementations in tests and benchmarks.
namespace nav::render::features::definition {

/// Mean and variance of the window in two passes over its voxels.
double signal_to_noise(const ScalarVolume& volume, const SnrOptions& options, int i, int j, int k);

/// Per mm, in the frame of the volume, per voxel, i fastest: gradient_at(), or the slopes of
/// Gaussians cut off at 8 sigmas. NaN at unknown voxels.
std::vector<Eigen::Vector3d> gradients(const ScalarVolume& volume, double smoothing_mm);

/// Eigenvalues (of derivatives normalised by sigma^2) ascending, per voxel, at one scale: filters
/// cut off at `truncate` sigmas, eigenvalues by iteration (Eigen's SelfAdjointEigenSolver). Voxels:
/// i fastest.
std::vector<std::array<double, 3>> eigenvalues(const ScalarVolume& volume, double sigma_mm,
                                               double truncate);
/// Frangi's measure of eigenvalues in any order.
double tube_response(std::array<double, 3> eigenvalues, const VesselnessOptions& options,
                     double contrast);
/// Over all scales, with filters of 8 sigmas; NaN at unknown voxels.
std::vector<double> vesselness(const ScalarVolume& volume, const VesselnessOptions& options);

}  // namespace nav::render::features::definition
