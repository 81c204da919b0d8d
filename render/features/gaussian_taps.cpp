// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/gaussian_taps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "nav/check.hpp"

namespace nav::render::features {

GaussianTaps gaussian_taps(double sigma_voxels, double truncate) {
  NAV_CHECK(sigma_voxels > 0 && truncate > 0 && std::isfinite(sigma_voxels * truncate),
            sigma_voxels, truncate);
  GaussianTaps taps;
  taps.radius = std::max(1, static_cast<int>(std::ceil(truncate * sigma_voxels)));
  const auto count = static_cast<std::size_t>(taps.radius) + 1;
  // Weights relative to that of the first neighbour. Their ratios survive if that weight
  // underflows.
  std::vector<double> tail(count);
  // The square of a small number may be 0. The exponent of the first neighbour would then be 0 / 0.
  const double two_variances =
      std::max(2 * sigma_voxels * sigma_voxels, std::numeric_limits<double>::min());
  double sum = 0, second = 0, fourth = 0;
  for (std::size_t k = 1; k < count; ++k) {
    const double k2 = static_cast<double>(k) * static_cast<double>(k);
    tail[k] = std::exp((1 - k2) / two_variances);
    sum += 2 * tail[k];
    second += 2 * k2 * tail[k];
    fourth += 2 * k2 * k2 * tail[k];
  }
  const double neighbour = std::exp(-1 / two_variances);
  const double total = 1 + neighbour * sum;
  const double variance = neighbour * second / total;  // Truncated, sampled Gaussian.
  // bend_k = scale * tail_k * (k^2 - variance), k > 0, with second moment 2 and sum 0.
  const double bend_scale = 2 / (fourth - variance * second);
  taps.smooth.assign(count, 1 / total);
  taps.slope.assign(count, 0);
  taps.bend.assign(count, 0);
  for (std::size_t k = 1; k < count; ++k) {
    const double at = static_cast<double>(k);
    taps.smooth[k] = neighbour * tail[k] / total;
    taps.slope[k] = tail[k] * at / second;
    taps.bend[k] = bend_scale * tail[k] * (at * at - variance);
    taps.bend[0] -= 2 * taps.bend[k];
  }
  return taps;
}

Result<void> check_reach(const FilterReach& filter, const VoxelGrid& grid,
                         const std::string& name) {
  constexpr double kMaxVoxels = 256;
  const double reach = filter.truncate * filter.sigma_mm / grid.spacing_mm.minCoeff();
  if (reach <= kMaxVoxels) return {};
  std::ostringstream text;
  text << name << ": expected filters of at most " << kMaxVoxels << " voxels, found " << reach
       << " voxels for " << filter.option << " " << filter.found_mm << " mm";
  return Error{ErrorCode::kUsage, text.str()};
}

FloatTaps::FloatTaps(const GaussianTaps& taps, double derivative_scale) {
  const auto rounded = [](const std::vector<double>& from, double scale) {
    std::vector<float> to(from.size());
    std::transform(from.begin(), from.end(), to.begin(),
                   [scale](double t) { return static_cast<float>(t * scale); });
    return to;
  };
  smooth_ = rounded(taps.smooth, 1);
  slope_ = rounded(taps.slope, derivative_scale);
  bend_ = rounded(taps.bend, derivative_scale * derivative_scale);
  double rest = 0;
  for (std::size_t k = 1; k < bend_.size(); ++k) rest += 2.0 * static_cast<double>(bend_[k]);
  bend_[0] = static_cast<float>(-rest);
}

}  // namespace nav::render::features
