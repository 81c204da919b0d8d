// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/organ.hpp"

namespace nav::sim {

Eigen::AlignedBox3d box_around(const shapes::Ellipsoid& e, double pad_mm) {
  const Vec3d half = (e.axes.cwiseAbs() * e.radii).array() + pad_mm;
  return {e.centre - half, e.centre + half};
}

Eigen::AlignedBox3d box_around(const shapes::Capsule& c, double pad_mm) {
  const Vec3d half = Vec3d::Constant(c.radius + pad_mm);
  return {c.from.cwiseMin(c.to) - half, c.from.cwiseMax(c.to) + half};
}

Eigen::Matrix3d turned(double about_x, double about_y, double about_z) {
  return (Eigen::AngleAxisd(about_z, Vec3d::UnitZ()) * Eigen::AngleAxisd(about_y, Vec3d::UnitY()) *
          Eigen::AngleAxisd(about_x, Vec3d::UnitX()))
      .toRotationMatrix();
}

shapes::Ellipsoid grown(shapes::Ellipsoid e, double mm) {
  e.radii.array() += mm;
  return e;
}

}  // namespace nav::sim
