// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_shape_rows.hpp"

#include <algorithm>

namespace nav::render {
namespace {

constexpr std::size_t kFirstVertex = 4;  // Same in the shader.

void append(const Eigen::Vector3d& v, double w, std::vector<float>& out) {
  for (const double number : {v.x(), v.y(), v.z(), w}) out.push_back(static_cast<float>(number));
}

void append(const spec::CapsuleSurface<double>& solid, GlRows& rows) {
  append(solid.a, solid.radius, rows.texels);
  append(solid.b, 0, rows.texels);
  append(solid.rgb, solid.alpha, rows.texels);
  ++rows.height;
}

/// A ball around a polygon, slightly enlarged so that rounding cannot leave a vertex outside.
spec::CutawayBall<double> around(const spec::CutawayPolygon<double>& polygon) {
  spec::CutawayBall<double> ball{Eigen::Vector3d::Zero(), 0};
  for (const auto& vertex : polygon.vertices) ball.centre += vertex;
  ball.centre /= static_cast<double>(polygon.vertices.size());
  for (const auto& vertex : polygon.vertices) {
    ball.radius = std::max(ball.radius, (vertex - ball.centre).norm());
  }
  ball.radius = 1.001 * ball.radius + 0.01;
  return ball;
}

}  // namespace

GlRows solid_rows(const Scene& scene) {
  const VoxelGrid& grid = scene.ct->grid();
  GlRows rows{3, 0, {}};
  if (scene.needle) {
    if (const auto needle = spec::make_needle<double>(*scene.needle, grid)) append(*needle, rows);
  }
  for (const auto& sphere : scene.spheres) append(spec::make_sphere<double>(sphere, grid), rows);
  for (const auto& line : scene.lines) append(spec::make_line<double>(line, grid), rows);
  return rows;
}

bool has_capsules(const Scene& scene) {
  const bool needle = scene.needle && scene.needle->safety.state != SafetyState::kLost;
  return needle || !scene.lines.empty();
}

GlRows cut_rows(const spec::CutawayObjects<double>& objects) {
  std::size_t most = 0;
  for (const auto& polygon : objects.polygons) most = std::max(most, polygon.vertices.size());
  const std::size_t width = kFirstVertex + most;
  GlRows rows{static_cast<int>(width), 0, {}};
  const auto add = [&](const spec::CutawayPolygon<double>& p, const spec::CutawayBall<double>& b) {
    append(p.normal, static_cast<double>(p.vertices.size()), rows.texels);
    append(p.axis_u, 0, rows.texels);
    append(p.axis_v, 0, rows.texels);
    append(b.centre, b.radius, rows.texels);
    for (const auto& vertex : p.vertices) append(vertex, 0, rows.texels);
    ++rows.height;
    rows.texels.resize(4 * width * static_cast<std::size_t>(rows.height));
  };
  const spec::CutawayPolygon<double> none{
      {}, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (const auto& polygon : objects.polygons) add(polygon, around(polygon));
  for (const auto& ball : objects.balls) add(none, ball);
  return rows;
}

}  // namespace nav::render
