// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "render/spec/ray_spec_cutaway.hpp"

/// Computes the truth for the closed forms of the cutaway by a search over the points of an object.
namespace nav::test {

/// Definition: depth along the ray up to which the point \p q clears.
inline double cone_value(const Eigen::Vector3d& q, const render::spec::Ray<double>& ray,
                         double cot) {
  const Eigen::Vector3d m = q - ray.origin;
  return m.dot(ray.direction) - cot * m.cross(ray.direction).norm();
}

/// Maximum of a concave function on [0, 1] by golden-section search.
template <class Function>
double concave_maximum(const Function& function) {
  constexpr int kSections = 60;
  const double golden = 0.5 * (std::sqrt(5.0) - 1);
  double low = 0;
  double high = 1;
  double a = high - golden;
  double b = low + golden;
  double at_a = function(a);
  double at_b = function(b);
  double best = std::max({function(0.0), function(1.0), at_a, at_b});
  for (int i = 0; i < kSections; ++i) {
    if (at_a < at_b) {
      low = a;
      a = b;
      at_a = at_b;
      b = low + golden * (high - low);
      at_b = function(b);
    } else {
      high = b;
      b = a;
      at_b = at_a;
      a = high - golden * (high - low);
      at_a = function(a);
    }
    best = std::max({best, at_a, at_b});
  }
  return best;
}

/// Best value over the points of a triangle. The definition is concave, and its maximum over r is
/// concave in s.
inline double best_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                      const render::spec::Ray<double>& ray, double cot) {
  return concave_maximum([&](double s) {
    return concave_maximum(
        [&](double r) { return cone_value(a + s * (b - a) + r * (1 - s) * (c - a), ray, cot); });
  });
}

/// Returns a polygon as make_cutaway() prepares it.
inline render::spec::CutawayPolygon<double> polygon_of(std::vector<Eigen::Vector3d> vertices) {
  const VoxelGrid grid{{1, 1, 1}};
  static const auto ct = std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, std::vector<std::int16_t>(1), "voxel"));
  render::Scene scene{.ct = ct,
                      .transfer = *render::TransferFunction::create(
                          "none", {{0, {1, 1, 1}, 0, 0}, {1, {1, 1, 1}, 0, 0}})};
  scene.cutaway.emplace();
  render::PolygonObject polygon;
  for (const auto& v : vertices) polygon.vertices_ct.push_back({v});
  scene.cutaway->polygons.push_back(std::move(polygon));
  return render::spec::make_cutaway(scene, true).polygons.front();
}

}  // namespace nav::test
