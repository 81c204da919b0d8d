// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/landmarks/tre_map.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"

namespace nav::registration {
namespace {

// A CT with wrong units of its spacing could ask for any number of nodes.
constexpr double kMostNodes = 4194304;

VoxelGrid nodes_over(const VoxelGrid& ct, double step_mm) {
  VoxelGrid grid = ct;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto e = static_cast<Eigen::Index>(axis);
    const double length = ct.spacing_mm[e] * std::max(ct.size[axis] - 1, 1);
    const double steps = std::min(length / step_mm, kMostNodes);
    grid.size[axis] = std::max(2, static_cast<int>(std::lround(steps)) + 1);
    grid.spacing_mm[e] = length / (grid.size[axis] - 1);
  }
  return grid;
}

}  // namespace

double TreMap::worst_mm() const {
  return rms_mm.empty() ? 0 : *std::max_element(rms_mm.begin(), rms_mm.end());
}

double TreMap::fraction_within(double limit_mm) const {
  if (rms_mm.empty()) return 0;
  const auto within =
      std::count_if(rms_mm.begin(), rms_mm.end(), [&](float x) { return x <= limit_mm; });
  return static_cast<double>(within) / static_cast<double>(rms_mm.size());
}

TreMap tre_map(const PoseUncertainty& uncertainty, const VoxelGrid& ct, double step_mm) {
  NAV_CHECK(step_mm > 0, step_mm);
  TreMap map{nodes_over(ct, step_mm), step_mm, {}};
  const auto nodes = [&] {
    return static_cast<double>(map.grid.size[0]) * map.grid.size[1] * map.grid.size[2];
  };
  while (nodes() > kMostNodes) {
    map.step_mm *= 2;
    map.grid = nodes_over(ct, map.step_mm);
  }
  map.rms_mm.reserve(map.grid.voxel_count());
  for (int k = 0; k < map.grid.size[2]; ++k) {
    for (int j = 0; j < map.grid.size[1]; ++j) {
      for (int i = 0; i < map.grid.size[0]; ++i) {
        const auto node = map.grid.at(Eigen::Vector3d(i, j, k));
        map.rms_mm.push_back(static_cast<float>(uncertainty.tre_rms_mm(node)));
      }
    }
  }
  return map;
}

}  // namespace nav::registration
