// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/smoothed_ct.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "render/parallel.hpp"

namespace nav::render {
namespace {

/// Weights of a sampled Gaussian, from -radius to radius, with the sum 1.
std::vector<float> smoothing_weights(double sigma_voxels) {
  constexpr double kEndSigmas = 3;
  const int radius = static_cast<int>(std::ceil(kEndSigmas * sigma_voxels));
  std::vector<double> weights;
  double sum = 0;
  for (int i = -radius; i <= radius; ++i) {
    const double u = i / sigma_voxels;
    weights.push_back(std::exp(-0.5 * u * u));
    sum += weights.back();
  }
  std::vector<float> out;
  for (const double w : weights) out.push_back(static_cast<float>(w / sum));
  return out;
}

/// Smooths along an axis. A line belongs to one slice across another axis, so threads share no
/// line. Rows along i are added up as wholes, because columns lie far apart in memory.
void smooth_lines(const std::array<int, 3>& size, int axis, double sigma_voxels, int threads,
                  std::vector<float>& values) {
  const std::vector<float> weights = smoothing_weights(sigma_voxels);
  const int radius = static_cast<int>(weights.size() / 2);
  const std::array<std::ptrdiff_t, 3> strides{1, size[0], std::ptrdiff_t{size[0]} * size[1]};
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  const int outer = axis == 2 ? 1 : 2;
  const int lines = axis == 0 ? size[1] : size[at(axis)];
  const std::ptrdiff_t stride = axis == 0 ? strides[1] : strides[at(axis)];
  const int width = size[0];
  for_each_index(size[at(outer)], threads, [&](int slice) {
    float* first = values.data() + slice * strides[at(outer)];
    std::vector<float> before(at(lines) * at(width));
    for (int line = 0; line < lines; ++line) {
      std::copy_n(first + line * stride, width, before.data() + std::ptrdiff_t{line} * width);
    }
    std::vector<float> sums(at(width));
    for (int line = 0; line < lines; ++line) {
      std::ranges::fill(sums, 0.0F);
      for (int k = -radius; k <= radius; ++k) {
        const float weight = weights[at(k + radius)];
        if (axis != 0) {
          const int from = std::clamp(line + k, 0, lines - 1);
          const float* row = before.data() + std::ptrdiff_t{from} * width;
          for (int i = 0; i < width; ++i) sums[at(i)] += weight * row[i];
          continue;
        }
        const float* row = before.data() + std::ptrdiff_t{line} * width;
        const int inside_from = std::clamp(-k, 0, width);
        const int inside_to = std::clamp(width - k, inside_from, width);
        for (int i = 0; i < inside_from; ++i) sums[at(i)] += weight * row[0];
        for (int i = inside_from; i < inside_to; ++i) sums[at(i)] += weight * row[i + k];
        for (int i = inside_to; i < width; ++i) sums[at(i)] += weight * row[width - 1];
      }
      std::copy_n(sums.data(), width, first + line * stride);
    }
  });
}

}  // namespace

Result<std::shared_ptr<const StoredVolume>> smoothed_for_gradients(
    const std::shared_ptr<const StoredVolume>& volume, double sigma_mm, int threads) {
  if (!(sigma_mm >= 0 && sigma_mm <= kMostSmoothingMm)) {
    std::ostringstream text;
    text << "smoothing of gradients: expected 0 to " << kMostSmoothingMm << " mm, found "
         << sigma_mm;
    return Error{ErrorCode::kUsage, text.str()};
  }
  if (sigma_mm == 0) return volume;
  const VoxelGrid& grid = volume->grid();
  std::vector<float> values(volume->values().begin(), volume->values().end());
  for (int axis = 0; axis < 3; ++axis) {
    // Below this the neighbours weigh less than 1e-5.
    constexpr double kLeastSigmaVoxels = 0.2;
    const double sigma = sigma_mm / grid.spacing_mm[axis];
    if (sigma > kLeastSigmaVoxels) smooth_lines(grid.size, axis, sigma, threads, values);
  }
  std::vector<std::int16_t> rounded(values.size());
  std::ranges::transform(values, rounded.begin(),
                         [](float v) { return static_cast<std::int16_t>(std::lround(v)); });
  auto made = StoredVolume::create(grid, std::move(rounded), volume->name());
  if (!made) return made.error();
  return std::make_shared<const StoredVolume>(*std::move(made));
}

}  // namespace nav::render
