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

/// Smooths every line along an axis. A line belongs to one slice across another axis, so threads
/// share no line.
void smooth_lines(const std::array<int, 3>& size, int axis, double sigma_voxels, int threads,
                  std::vector<float>& values) {
  const std::vector<float> weights = smoothing_weights(sigma_voxels);
  const int radius = static_cast<int>(weights.size() / 2);
  const std::array<std::ptrdiff_t, 3> strides{1, size[0], std::ptrdiff_t{size[0]} * size[1]};
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  const int outer = axis == 2 ? 1 : 2;
  const int inner = axis == 0 ? 1 : 0;
  const int count = size[at(axis)];
  const std::ptrdiff_t stride = strides[at(axis)];
  for_each_index(size[at(outer)], threads, [&](int slice) {
    std::vector<float> line(at(count));
    for (int row = 0; row < size[at(inner)]; ++row) {
      float* first = values.data() + slice * strides[at(outer)] + row * strides[at(inner)];
      for (int i = 0; i < count; ++i) line[at(i)] = first[i * stride];
      for (int i = 0; i < count; ++i) {
        float sum = 0;
        for (int k = -radius; k <= radius; ++k) {
          sum += weights[at(k + radius)] * line[at(std::clamp(i + k, 0, count - 1))];
        }
        first[i * stride] = sum;
      }
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
