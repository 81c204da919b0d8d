// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "sim/anatomy/field.hpp"
#include "sim/anatomy/sheets.hpp"
#include "sim/shapes.hpp"
#include "sim/tissue.hpp"

/// Parts of simulated patients. Private to sim/. CT coordinates, mm.
namespace nav::sim {

/// Fibres of muscle and tendon: scatterers are arranged along them, and echoes are strongest where
/// the beam is perpendicular to them.
struct Grain {
  Vec3d along{0, 0, 0};   ///< Unit vector; zero: none.
  double length_mm = 1;   ///< Length over which a strand is uniform, > 0.
  double spacing_mm = 1;  ///< Distance between strands, > 0.
  double strength = 0;    ///< Strength of the contrast of the strands, [0, 1].
  double between = 1;     ///< Scatter as a multiple of the tissue's, without septa.
  /// Distance between septa; it varies by a third from patient to patient; 0: none.
  double septa_mm = 0;
};

/// Shape of one tissue. Later organs of a list cover earlier ones.
struct Organ {
  Tissue tissue;
  Field distance_mm;
  Eigen::AlignedBox3d bounds;  ///< Contains every point with a distance below 2 mm.
  Grain grain{};
  std::vector<WallLayer> layers{};
};

/// Boxes around a shape, enlarged by \p pad_mm.
Eigen::AlignedBox3d box_around(const shapes::Ellipsoid& e, double pad_mm);
Eigen::AlignedBox3d box_around(const shapes::Capsule& c, double pad_mm);

/// Axes rotated about x, then y, then z, rad.
Eigen::Matrix3d turned(double about_x, double about_y, double about_z);

/// Ellipsoid with radii changed by \p mm.
shapes::Ellipsoid grown(shapes::Ellipsoid e, double mm);

}  // namespace nav::sim
