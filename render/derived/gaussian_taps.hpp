// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/derived/kernels.hpp"

namespace nav::render::derived {

/// A sampled Gaussian and its first two derivatives for unit spacing, cut off at a radius, with
/// moments mended: smoothing keeps constants, the slope of k is 1 and the bend of k^2 is 2 exactly,
/// so that below half a voxel they become central differences instead of nonsense. Folded.
struct GaussianTaps {
  int radius = 1;              ///< >= 1.
  std::vector<double> smooth;  ///< Sum is 1.
  std::vector<double> slope;   ///< Per voxel.
  std::vector<double> bend;    ///< Per voxel squared.
};
/// sigma_voxels > 0; truncate: radius in sigmas, > 0.
GaussianTaps gaussian_taps(double sigma_voxels, double truncate);

/// The same rounded to float, with the derivatives scaled; constants still vanish exactly as far as
/// float sums allow.
class FloatTaps {
 public:
  FloatTaps(const GaussianTaps& taps, double derivative_scale);
  [[nodiscard]] int radius() const { return static_cast<int>(smooth_.size()) - 1; }
  [[nodiscard]] FoldedTaps folded() const { return {smooth_.data(), slope_.data(), bend_.data()}; }

 private:
  std::vector<float> smooth_, slope_, bend_;
};

}  // namespace nav::render::derived
