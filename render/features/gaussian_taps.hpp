// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/volume.hpp"
#include "render/features/kernels.hpp"

namespace nav::render::features {

/// A sampled Gaussian and its first two derivatives for unit spacing, cut off at a radius, with
/// corrected moments: smoothing keeps constants, the slope of k is exactly 1, and the bend of k^2
/// is exactly 2. Below half a voxel they therefore become central differences. Stored folded (see
/// FoldedTaps).
struct GaussianTaps {
  int radius = 1;              ///< >= 1.
  std::vector<double> smooth;  ///< Sum is 1.
  std::vector<double> slope;   ///< Weights of the first derivative, per voxel.
  std::vector<double> bend;    ///< Weights of the second derivative, per voxel squared.
};
/// sigma_voxels > 0; truncate: radius in sigmas, > 0.
GaussianTaps gaussian_taps(double sigma_voxels, double truncate);

/// The widest filter of a feature, and the option that sets it.
struct FilterReach {
  const char* option;
  double found_mm;  ///< Value of the option.
  double sigma_mm, truncate;
};
/// Rejects filters of hundreds of voxels, because they indicate wrong units.
Result<void> check_reach(const FilterReach& filter, const VoxelGrid& grid, const std::string& name);

/// GaussianTaps rounded to float, with scaled derivatives. Derivatives of constants still vanish as
/// exactly as float sums allow.
class FloatTaps {
 public:
  FloatTaps(const GaussianTaps& taps, double derivative_scale);
  [[nodiscard]] int radius() const { return static_cast<int>(smooth_.size()) - 1; }
  [[nodiscard]] FoldedTaps folded() const { return {smooth_.data(), slope_.data(), bend_.data()}; }

 private:
  std::vector<float> smooth_, slope_, bend_;
};

}  // namespace nav::render::features
