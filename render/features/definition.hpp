// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>

#include "render/features/gradient.hpp"
#include "render/features/snr.hpp"
#include "render/features/vesselness.hpp"

/// Definitions of the derived volumes in double precision, without any optimisation. Tests and
/// benchmarks compare the fast implementations with them.
namespace nav::render::features::definition {

/// Signal-to-noise ratio at a voxel: mean and variance of the window in two passes over its voxels.
double signal_to_noise(const ScalarVolume& volume, const SnrOptions& options, int i, int j, int k);

/// Gradients per voxel, i fastest, per mm, in the frame of the volume: gradient_at(), or the slopes
/// of Gaussians cut off at 8 sigmas. NaN at unknown voxels.
std::vector<Eigen::Vector3d> gradients(const ScalarVolume& volume, double smoothing_mm);

/// Ascending eigenvalues of the derivatives normalised by sigma^2, at one scale, per voxel, i
/// fastest. Filters are cut off at `truncate` sigmas. Eigenvalues by iteration (Eigen's
/// SelfAdjointEigenSolver).
std::vector<std::array<double, 3>> eigenvalues(const ScalarVolume& volume, double sigma_mm,
                                               double truncate);
/// Frangi's measure for eigenvalues in any order.
double tube_response(std::array<double, 3> eigenvalues, const VesselnessOptions& options,
                     double contrast);
/// Greatest response over all scales, with filters cut off at 8 sigmas; NaN at unknown voxels.
std::vector<double> vesselness(const ScalarVolume& volume, const VesselnessOptions& options);

}  // namespace nav::render::features::definition
