// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/features/run.hpp"
#include "render/features/volume.hpp"

namespace nav::render::features {

enum class Polarity { kBright, kDark };

/// Multi-scale vesselness after Frangi et al. 1998, on Gaussian second derivatives in mm,
/// normalised by sigma^2 (Lindeberg). A straight tube of radius r and contrast C responds most
/// strongly at sigma = r / sqrt(2), with both cross eigenvalues at -C/e. Scales are therefore given
/// as radii.
struct VesselnessOptions {
  Polarity polarity = Polarity::kDark;  ///< Brightness of the lumen; blood is dark in B-mode.
  double smallest_radius_mm = 0.8;      ///< (0, largest_radius_mm].
  double largest_radius_mm = 3.0;       ///< At most 100.
  int scales = 4;                       ///< [1, 16], at equal ratios; 1: the geometric mean.
  double alpha = 0.5;                   ///< Separates plates from lines, > 0.
  double beta = 0.5;                    ///< Separates blobs from lines, > 0.
  /// Difference of intensity between lumen and surroundings of a full vessel, > 0. 0: half of the
  /// distance between the 1st and the 99th percentile of the volume, or half of the whole range if
  /// these are equal. Frangi's c, half of the greatest norm, is that of the ideal tube with this
  /// contrast, contrast / (sqrt(2) e), and therefore does not depend on the brightest voxel.
  double contrast = 0;
  double truncate = 4;  ///< Radius of the filters in sigmas, [2, 8]: larger is slower and more
                        ///< accurate.
  /// Bricks whose response is provably smaller stay at 0, [0, 0.1].
  double negligible_response = 1e-4;
};
Result<void> validate(const VesselnessOptions& options);
/// Also rejects filters that would reach hundreds of voxels of a grid. \p name: name of the volume.
Result<void> validate(const VesselnessOptions& options, const VoxelGrid& grid,
                      const std::string& name);

/// Sigmas of the scales, mm, ascending.
std::vector<double> sigmas_mm(const VesselnessOptions& options);
/// The contrast of the options, or the automatic one.
double contrast_of(const VesselnessOptions& options, const ScalarVolume& volume, int threads);

/// Response in [0, 1]; NaN at unknown voxels, 0 everywhere in a constant volume. Takes about 8
/// bytes per voxel, 14 with unknown voxels. Borders and unknown voxels: see FilledField.
Result<FeatureVolume> vesselness(const ScalarVolume& volume, const VesselnessOptions& options,
                                 const RunOptions& run = {});

}  // namespace nav::render::features
