// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/features/run.hpp"
#include "render/features/volume.hpp"

namespace nav::render::features {

/// Weights of the voxels of a window.
enum class WindowWeights {
  kUniform,   ///< All equal: "a uniform 7 x 7 x 7 kernel" (Schulte zu Berge et al. 2014, §3.1).
  kGaussian,  ///< exp(-d^2 / (2 s^2)) along each axis, s a quarter of the side: no blocky edges.
};

/// Signal-to-noise ratio of a neighbourhood. With weights w over the known voxels f of the window,
/// m = sum w f / sum w, v = sum w (f - m)^2 / sum w, and SNR = (m - black) / max(sqrt(v), floor).
/// Voxels beyond the border and unknown voxels have no weight. The floor is the noise of rounding
/// to integers, quantum / sqrt(12). Without it (float volumes) a constant window gives +-infinity,
/// or NaN if m = black.
struct SnrOptions {
  int window_voxels = 7;  ///< Side of the window, odd, [3, 31].
  WindowWeights weights = WindowWeights::kUniform;
  double black = 0;  ///< Value without an echo, finite.
};
Result<void> validate(const SnrOptions& options);

/// Weights along one axis, from -r to r; the greatest is 1.
std::vector<double> window_weights(const SnrOptions& options);

/// Computes the SNR per voxel, in double precision; NaN at unknown voxels. Takes about 4 bytes per
/// voxel.
Result<FeatureVolume> signal_to_noise(const ScalarVolume& volume, const SnrOptions& options = {},
                                      const RunOptions& run = {});

/// Maps a ratio to [0, 1]: 0 at low and below, 1 at high and above, linear between; NaN stays NaN.
/// Precondition: low < high.
double windowed(double snr, double low, double high);

}  // namespace nav::render::features
