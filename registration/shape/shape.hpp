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

/// Degrees of freedom that a shape leaves to each of its points: a surface lets points slide in its
/// plane, a curve lets them slide along its tangent.
enum class ShapeKind { kSurface, kCurve };

/// One piece of a shape.
struct ShapeElement {
  Eigen::Vector3d point_mm;  ///< Ct.
  /// Ct, unit: the surface's normal (of either sign) or the curve's tangent.
  Eigen::Vector3d axis;
};

/// A surface or the centre lines of vessels in the CT, divided into pieces about spacing_mm apart.
struct Shape {
  ShapeKind kind;
  std::vector<ShapeElement> elements;
  double spacing_mm;
  std::string name;
};

/// Divides a surface into pieces: one or more for every triangle, none farther than spacing_mm from
/// the next. Triangles without area are left out. Rejects indices outside the points, points that
/// are not finite, a spacing outside 0.1 to 20 mm, more than 2^24 pieces, and a mesh without area.
Result<Shape> surface_shape(const TriangleMesh& mesh, double spacing_mm);

/// A branch of a vessel tree: its centre line, mm.
template <class Frame>
using CentreLine = std::vector<Point<Frame>>;

/// Divides centre lines into pieces, spacing_mm apart or closer. Rejects the same faults as
/// surface_shape(); lines without length are left out.
Result<Shape> curve_shape(const std::vector<CentreLine<frames::Ct>>& lines, double spacing_mm,
                          const std::string& name);

/// Points along centre lines, at most spacing_mm (> 0) apart, to be registered to a curve_shape().
std::vector<Point<frames::Reference>> points_along(
    const std::vector<CentreLine<frames::Reference>>& lines, double spacing_mm);

}  // namespace nav::registration
