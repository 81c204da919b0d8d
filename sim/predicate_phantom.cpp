// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/predicate_phantom.hpp"

#include <algorithm>
#include <cmath>

namespace nav::sim {
namespace {

constexpr double kNeckSideMm = 40;

/// Distance of a point from the vessel's axis, mm, and the radius there: a tube that forks.
double off_vessel(const Eigen::Vector3d& p) {
  const double bend = 3 * std::sin(p.x() / 9);
  const double fork = std::max(0.0, p.x() - 22) * 0.35;
  const double y = p.y() - 22 - bend;
  const double left = std::hypot(y, p.z() - 20 - fork) - 2.6;
  const double right = std::hypot(y, p.z() - 20 + fork) - 2.2;
  return std::min(left, right);
}

/// Counter-based noise in (0, 1].
double uniform_noise(std::uint64_t i) {
  std::uint64_t x = (i + 1) * 0x9E3779B97F4A7C15U;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9U;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBU;
  return (static_cast<double>((x ^ (x >> 31)) >> 11) + 1) / 9007199254740992.0;
}

/// Reflectivity of tissue, [0, 1].
double reflectivity(const Eigen::Vector3d& p) {
  const double vessel = off_vessel(p);
  if (vessel < 0) return 0.04;
  if (vessel < 0.8) return 0.8;
  if (p.y() < 3) return 0.9;
  if (p.y() < 14) return 0.35 + 0.25 * std::pow(std::sin(2.2 * p.y() + 0.15 * p.x()), 8);
  return 0.3;
}

std::int16_t neck_echo(const Eigen::Vector3d& p, std::uint64_t i) {
  const double speckle = std::sqrt(-2 * std::log(uniform_noise(i))) * 0.8;
  const double shown = 255 * reflectivity(p) * (0.35 + 0.65 * speckle) * std::exp(-p.y() / 60);
  return static_cast<std::int16_t>(std::clamp(std::lround(shown), 0L, 255L));
}

/// Values of all voxels, i fastest: of(position in mm).
template <class T, class Of>
std::vector<T> of_positions(const VoxelGrid& grid, const Of& of) {
  std::vector<T> values;
  values.reserve(grid.voxel_count());
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        values.push_back(of(grid.at({double(i), double(j), double(k)}).mm));
      }
    }
  }
  return values;
}

}  // namespace

std::vector<float> neck_vesselness(const VoxelGrid& grid) {
  return of_positions<float>(grid, [](const Eigen::Vector3d& p) {
    const double off = off_vessel(p);
    return static_cast<float>(off < 0 ? 1 : std::exp(-0.5 * off * off));
  });
}

Result<PredicatePhantom> neck_volume(int n) {
  VoxelGrid grid;
  grid.size = {n, n, n};
  grid.spacing_mm.setConstant(kNeckSideMm / n);
  std::vector<std::int16_t> voxels(grid.voxel_count());
  std::size_t at = 0;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i, ++at) {
        voxels[at] = neck_echo(grid.at({double(i), double(j), double(k)}).mm, at);
      }
    }
  }
  auto made = StoredVolume::create(grid, std::move(voxels), "neck phantom");
  if (!made) return made.error();
  auto labels = of_positions<std::uint32_t>(grid, [](const Eigen::Vector3d& p) {
    return p.y() < 3 ? 1U : off_vessel(p) < 0.8 ? 4U : 2U;
  });
  return PredicatePhantom{.name = "neck-" + std::to_string(n),
                          .ultrasound = std::make_shared<const StoredVolume>(*std::move(made)),
                          .face_ct = {{0, 0, 0}},
                          .into_ct = {{0, 1, 0}},
                          .labels = std::move(labels),
                          .labels_name = "layers"};
}

}  // namespace nav::sim
