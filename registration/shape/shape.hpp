// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "nav/triangle_mesh.hpp"

namespace nav::registration {

/// What a shape leaves free at each of its points: a surface lets points slide in its plane, a
/// curve along its tangent.
enum class ShapeKind { kSurface, kCurve };

/// One piece of a shape.
struct ShapeElement {
  Eigen::Vector3d point_mm;  ///< Ct.
  Eigen::Vector3d axis;      ///< Ct, unit: the surface's normal, of either sign, or the tangent.
};

/// A surface or the centre lines of vessels in the CT, cut into pieces about spacing_mm apart.
struct Shape {
  ShapeKind kind;
  std::vector<ShapeElement> elements;
  double spacing_mm;
  std::string name;
};

/// Pieces of a surface: of every triangle one or more, none farther than spacing_mm from the next.
/// Triangles without area are left out. Refuses indices outside the points, points that are not
/// finite, a spacing outside 0.1 to 20 mm, more than 2^24 pieces, and a mesh without area.
Result<Shape> surface_shape(const TriangleMesh& mesh, double spacing_mm);

/// A branch of a vessel tree: its centre line, mm.
template <class Frame>
using CentreLine = std::vector<Point<Frame>>;

/// Pieces of centre lines, spacing_mm apart or closer. Refuses like surface_shape(); lines without
/// length are left out.
Result<Shape> curve_shape(const std::vector<CentreLine<frames::Ct>>& lines, double spacing_mm,
                          const std::string& name);

/// Points along centre lines, at most spacing_mm (> 0) apart: what is laid onto a curve_shape().
std::vector<Point<frames::Reference>> points_along(
    const std::vector<CentreLine<frames::Reference>>& lines, double spacing_mm);

}  // namespace nav::registration
