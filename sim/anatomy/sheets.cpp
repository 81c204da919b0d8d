// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/sheets.hpp"

#include <Eigen/Geometry>

#include "nav/check.hpp"

namespace nav::sim {

Septa::Septa(const Vec3d& along, const Vec3d& normal, double spacing_mm, double echo,
             std::uint64_t seed)
    : along_(along),
      beside_(normal.cross(along)),
      normal_(normal),
      spacing_mm_(spacing_mm),
      echo_(echo),
      seed_(hash_bits(seed)) {
  NAV_CHECK(spacing_mm > 0 && std::abs(along.dot(normal)) < 1e-9, spacing_mm, along.dot(normal));
  Random random(seed, 0x736570746120);
  for (double& phase : phase_) phase = random.uniform(0, 1);
}

}  // namespace nav::sim
