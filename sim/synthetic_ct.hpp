// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "nav/volume.hpp"

namespace nav::sim {

/// An analytic abdomen in arterial phase, LPS mm about the origin, 340 × 260 × 300 mm: skin, fat,
/// muscle, liver on the patient's right (x < 0) with vessels and a lesion, aorta in front of a
/// spine of vertebrae, ribs, kidneys. Surfaces are blurred over 1.5 mm like those of a scanner,
/// with hashed noise of 12 HU. For images and timing; nothing is anatomically measured.
class SyntheticAbdomen {
 public:
  static double hu(const Eigen::Vector3d& p) {
    const double x = p.x();
    const double y = p.y();
    double v = -1000;
    const double body = 1 - std::hypot(x / 160, y / 118);
    v = mix(v, -95, body * 120);
    const double wall = 1 - std::hypot(x / 142, y / 100);
    v = mix(v, 55, wall * 110);
    const double cavity = 1 - std::hypot(x / 122, (y + 8) / 78);
    v = mix(v, -80, cavity * 90);
    v = mix(v, 110, ellipsoid(p, {-55, -15, 40}, {68, 58, 75}));  // Liver.
    v = mix(v, 45, ellipsoid(p, {-30, -30, 55}, {9, 9, 9}));      // Its lesion.
    v = mix(v, 55, ellipsoid(p, {60, -25, 60}, {42, 35, 50}));    // Stomach.
    v = mix(v, 190, ellipsoid(p, {55, 38, -20}, {26, 20, 50}));   // Kidneys.
    v = mix(v, 190, ellipsoid(p, {-55, 40, -35}, {26, 20, 50}));
    v = mix(v, 330, tube(p, {12, 28, -150}, {8, 26, 150}, 10.5));  // Aorta.
    v = mix(v, 320, tube(p, {12, 28, 30}, {-20, -5, 38}, 4));      // Coeliac trunk.
    v = mix(v, 300, tube(p, {-20, -5, 38}, {-62, -20, 50}, 3.2));  // Hepatic artery.
    v = mix(v, 290, tube(p, {-62, -20, 50}, {-92, -40, 78}, 2.4));
    v = mix(v, 290, tube(p, {-62, -20, 50}, {-95, 5, 30}, 2.4));
    v = mix(v, 320, tube(p, {12, 28, -5}, {45, 36, -18}, 3.2));  // Renal arteries.
    v = mix(v, 320, tube(p, {12, 28, -10}, {-45, 38, -32}, 3.2));
    v = mix(v, 320, tube(p, {10, 28, -120}, {45, 20, -160}, 7));
    v = mix(v, 320, tube(p, {10, 28, -120}, {-28, 20, -160}, 7));
    return std::max(v, bones(p, v));
  }

  /// n voxels along each axis, filling 340 mm; noise on.
  static std::shared_ptr<const Volume> volume(int n) {
    VoxelGrid grid;
    grid.size = {n, n, n};
    grid.spacing_mm = Eigen::Vector3d::Constant(340.0 / n);
    grid.origin_mm = Eigen::Vector3d::Constant(-0.5 * (n - 1) * 340.0 / n);
    std::vector<std::int16_t> voxels;
    voxels.reserve(grid.voxel_count());
    std::uint32_t count = 0;
    for (int k = 0; k < n; ++k) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          const double v = hu(grid.at({1.0 * i, 1.0 * j, 1.0 * k}).mm);
          voxels.push_back(static_cast<std::int16_t>(std::lround(v + 12 * noise(count++))));
        }
      }
    }
    return std::make_shared<Volume>(
        *Volume::create(grid, std::move(voxels), "synthetic abdomen " + std::to_string(n)));
  }

 private:
  /// b if the signed depth (mm) is positive, a if it is negative, blurred over 1.5 mm.
  static double mix(double a, double b, double depth_mm) {
    const double w = std::clamp(0.5 + depth_mm / 1.5, 0.0, 1.0);
    return a + w * (b - a);
  }
  static double ellipsoid(const Eigen::Vector3d& p, const Eigen::Vector3d& centre,
                          const Eigen::Vector3d& radii) {
    return (1 - (p - centre).cwiseQuotient(radii).norm()) * radii.minCoeff();
  }
  static double tube(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                     double radius) {
    const Eigen::Vector3d u = b - a;
    const double t = std::clamp((p - a).dot(u) / u.squaredNorm(), 0.0, 1.0);
    return radius - (p - a - t * u).norm();
  }
  static double bones(const Eigen::Vector3d& p, double v) {
    // Vertebrae every 36 mm: cortex of 900 HU about a core of 280 HU; discs between.
    const double z = p.z() - 36 * std::round(p.z() / 36);
    const double round = 21 - std::hypot(p.x(), (p.y() - 62) * 1.15);
    const double vertebra = std::min(round, 14 - std::abs(z));
    v = mix(v, 90, std::min(round - 1, 18.5 - std::abs(z)));
    v = mix(v, 900, vertebra);
    v = mix(v, 280, vertebra - 2.5);
    const double arch =
        std::max(tube({std::abs(p.x()), p.y(), z}, {10, 80, 0}, {32, 84, 4}, 5),
                 tube({0.8 * std::abs(p.x()), p.y(), z}, {0, 84, 0}, {0, 104, -8}, 5));
    v = mix(v, 800, arch);
    // Ribs slope down to the front, in the upper abdomen only.
    const double slope = p.z() + 0.28 * p.y();
    if (slope > -20) {
      const double s = slope - 28 * std::round(slope / 28);
      const double ring = std::hypot(p.x() / 138, p.y() / 96);
      const double rib = 4.5 - std::hypot((1 - ring) * 96, 0.75 * s);
      const bool open_front = p.y() < -60 && std::abs(p.x()) < 75;
      if (!open_front) v = mix(v, 750, rib);
    }
    return v;
  }
  /// Uniform-sum noise of unit variance from a counter.
  static double noise(std::uint32_t n) {
    double sum = 0;
    for (std::uint32_t i = 0; i < 3; ++i) {
      std::uint32_t h = n * 3 + i;
      h = (h ^ (h >> 16)) * 0x7feb352dU;
      h = (h ^ (h >> 15)) * 0x846ca68bU;
      sum += static_cast<double>(h ^ (h >> 16)) / 4294967296.0;
    }
    return (sum - 1.5) * 2;
  }
};

}  // namespace nav::sim
