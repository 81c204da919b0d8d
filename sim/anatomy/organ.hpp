// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "sim/anatomy/field.hpp"
#include "sim/anatomy/sheets.hpp"
#include "sim/shapes.hpp"
#include "sim/tissue.hpp"

/// What simulated patients are stacked from. Private to sim/. CT coordinates, mm.
namespace nav::sim {

/// Fibres of muscle and tendon: what scatters is strung along them, and echoes are strongest where
/// the beam meets them square.
struct Grain {
  Vec3d along{0, 0, 0};   ///< Unit vector; zero: none.
  double length_mm = 1;   ///< Over which a strand keeps its look, > 0.
  double spacing_mm = 1;  ///< Between strands, > 0.
  double strength = 0;    ///< Of the strands' contrast, [0, 1].
  double between = 1;     ///< Scatter as a multiple of the tissue's, septa aside.
  double septa_mm = 0;    ///< Between septa, give or take a third from patient to patient; 0: none.
};

/// One shape of one tissue. Later organs of a list cover earlier ones.
struct Organ {
  Tissue tissue;
  Field distance_mm;
  Eigen::AlignedBox3d bounds;  ///< Holds every point with distance below 2 mm.
  Grain grain{};
  std::vector<WallLayer> layers{};
};

/// Boxes that hold a shape with room around it.
Eigen::AlignedBox3d box_around(const shapes::Ellipsoid& e, double pad_mm);
Eigen::AlignedBox3d box_around(const shapes::Capsule& c, double pad_mm);

/// Axes turned about x, then y, then z, rad.
Eigen::Matrix3d turned(double about_x, double about_y, double about_z);

/// An ellipsoid with radii changed by so much.
shapes::Ellipsoid grown(shapes::Ellipsoid e, double mm);

}  // namespace nav::sim
