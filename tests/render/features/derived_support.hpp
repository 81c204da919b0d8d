// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "render/features/volume.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::test {

/// Returns float voxels as a function of their indices. NaN is unknown.
inline render::features::ScalarVolume make_scalar(
    const VoxelGrid& grid, const std::function<double(int, int, int)>& value) {
  std::vector<float> values;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        values.push_back(static_cast<float>(value(i, j, k)));
      }
    }
  }
  return *render::features::ScalarVolume::create(grid, std::move(values), "test volume");
}

/// Returns float voxels as a function of their positions, mm.
inline render::features::ScalarVolume make_scalar_at(
    const VoxelGrid& grid, const std::function<double(const Eigen::Vector3d&)>& value) {
  return make_scalar(
      grid, [&](int i, int j, int k) { return value(grid.at(Eigen::Vector3d(i, j, k)).mm); });
}

/// Returns speckle-like values of 0 to 255 with smooth structure below.
inline render::features::ScalarVolume speckled(const VoxelGrid& grid, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise;
  return make_scalar_at(grid, [&](const Eigen::Vector3d& p) {
    const double mean = 80 + 40 * std::sin(0.9 * p.x()) * std::cos(0.7 * p.y() + 0.3 * p.z());
    const double amplitude = std::hypot(noise(random), noise(random)) / std::sqrt(2.0);
    return std::clamp(mean * amplitude, 0.0, 255.0);
  });
}

/// Compares bits, so NaN equals NaN.
inline bool same_bytes(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

/// Largest difference over the known voxels. Expects that the same voxels are unknown in both.
inline double largest_difference(const render::features::FeatureVolume& found,
                                 const std::vector<double>& truth) {
  double worst = 0;
  for (std::size_t n = 0; n < truth.size(); ++n) {
    EXPECT_EQ(std::isnan(truth[n]), std::isnan((*found.values)[n])) << n;
    if (!std::isnan(truth[n])) {
      worst = std::max(worst, std::abs(truth[n] - static_cast<double>((*found.values)[n])));
    }
  }
  return worst;
}

}  // namespace nav::test
