// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_cutaway_plan.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace nav::render {
namespace {

constexpr std::size_t kSpare = 8;  // Room for lanes that read or write past the last object.

void set(const Eigen::Vector3d& from, float* to) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(from[i]);
}

/// The middle of the box around all objects.
Eigen::Vector3d middle_of(const spec::CutawayObjects<double>& objects) {
  Eigen::AlignedBox3d box;
  for (const auto& polygon : objects.polygons) {
    for (const Eigen::Vector3d& vertex : polygon.vertices) box.extend(vertex);
  }
  for (const auto& ball : objects.balls) box.extend(ball.centre);
  return box.isEmpty() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(box.center());
}

/// The ray at a position in pixels; equal to spec::ray_of() at pixel centres.
spec::Ray<double> ray_at(const spec::View<double>& view, double x, double y) {
  const double pixel = 2 * view.half_height / view.height;
  const double a = (x + 0.5 - 0.5 * view.width) * pixel;
  const double b = (0.5 * view.height - y - 0.5) * pixel;
  const Eigen::Vector3d offset = a * view.right + b * view.up;
  if (view.orthographic) return {view.eye + offset, view.forward};
  return {view.eye, (view.forward + offset).normalized()};
}

/// Moves the origin to the foot of a point and makes it relative to that point. Returns the
/// distance moved, mm.
double to_foot(const Eigen::Vector3d& centre, spec::Ray<double>& ray) {
  const Eigen::Vector3d to = centre - ray.origin;
  const double along = to.dot(ray.direction);
  ray.origin = along * ray.direction - to;
  return along;
}

}  // namespace

CutPlan::CutPlan(const spec::CutawayObjects<double>& objects) : centre_(middle_of(objects)) {
  for (const auto& polygon : objects.polygons) add(polygon);
  for (const auto& ball : objects.balls) {
    CutBall out{{0, 0, 0}, static_cast<float>(ball.radius)};
    set(ball.centre - centre_, out.centre);
    balls_.push_back(out);
  }
  view_ = {.edges = edges_.data(),
           .edge_count = static_cast<int>(edges_.size()),
           .polygons = polygons_.data(),
           .polygon_count = static_cast<int>(polygons_.size()),
           .balls = balls_.data(),
           .ball_count = static_cast<int>(balls_.size()),
           .cot = {},
           .per_sine = {},
           .sine = {}};
  const double cot[2] = {objects.cot1, objects.cot2};
  for (int k = 0; k < 2; ++k) {
    view_.cot[k] = static_cast<float>(cot[k]);
    view_.per_sine[k] = static_cast<float>(std::hypot(1, cot[k]));
    view_.sine[k] = static_cast<float>(1 / std::hypot(1, cot[k]));
  }
}

void CutPlan::add(const spec::CutawayPolygon<double>& polygon) {
  const auto id = static_cast<int>(polygons_.size());
  CutPolygon out{.normal = {},
                 .axis_u = {},
                 .axis_v = {},
                 .vertex = {},
                 .first_edge = static_cast<int>(edges_.size()),
                 .edges = 0};
  set(polygon.normal, out.normal);
  set(polygon.axis_u, out.axis_u);
  set(polygon.axis_v, out.axis_v);
  set(polygon.vertices[0] - centre_, out.vertex);
  const std::size_t n = polygon.vertices.size();
  for (std::size_t i = n > 2 ? 0 : 1, j = i > 0 ? 0 : n - 1; i < n; j = i++) {
    const Eigen::Vector3d a = polygon.vertices[j] - centre_;
    const Eigen::Vector3d b = polygon.vertices[i] - centre_;
    const double ua = a.dot(polygon.axis_u);
    const double va = a.dot(polygon.axis_v);
    const double ub = b.dot(polygon.axis_u);
    const double vb = b.dot(polygon.axis_v);
    CutEdge edge{.a = {},
                 .along = {},
                 .u = {static_cast<float>(ua), static_cast<float>(ub)},
                 .v = {static_cast<float>(va), static_cast<float>(vb)},
                 .u_per_v = 0,
                 .polygon = id};
    if (edge.v[0] != edge.v[1]) edge.u_per_v = static_cast<float>((ub - ua) / (vb - va));
    set(a, edge.a);
    set(b - a, edge.along);
    edges_.push_back(edge);
    ++out.edges;
  }
  polygons_.push_back(out);
}

CutSelection::CutSelection(const CutObjects& objects)
    : edges_(static_cast<std::size_t>(objects.edge_count) + kSpare),
      polygons_(static_cast<std::size_t>(objects.polygon_count) + kSpare),
      inside_(std::make_unique<bool[]>(polygons_.size())),
      upper_(2 * edges_.size()),
      choice_{.edges = edges_.data(),
              .edge_count = objects.edge_count,
              .polygons = polygons_.data(),
              .inside = inside_.get(),
              .polygon_count = objects.polygon_count,
              .upper = upper_.data()} {
  std::iota(edges_.begin(), edges_.end(), 0);
  std::iota(polygons_.begin(), polygons_.end(), 0);
}

CutBlock cut_block(const spec::View<double>& view, const Eigen::Vector3d& centre, int x0, int y0,
                   int size) {
  CutBlock block{};
  const double half = 0.5 * (size - 1);
  spec::Ray<double> middle = ray_at(view, x0 + half, y0 + half);
  double angle = 0;
  double shift = 0;
  for (int i = 0; i < 4; ++i) {
    spec::Ray<double> ray = ray_at(view, x0 + (i % 2) * 2 * half, y0 + (i / 2) * 2 * half);
    const double chord = (ray.direction - middle.direction).norm();
    angle = std::max(angle, 2 * std::asin(std::min(0.5 * chord, 1.0)));
    shift = std::max(shift, (ray.origin - middle.origin).norm());
    to_foot(centre, ray);
    set(ray.origin, block.corner_origin[i]);
    set(ray.direction, block.corner_direction[i]);
  }
  const double eye = to_foot(centre, middle);
  set(middle.origin, block.origin);
  set(middle.direction, block.direction);
  block.foot = static_cast<float>(eye);
  block.eye = view.orthographic ? 0 : static_cast<float>(eye);
  constexpr double kUp = 1.001;
  block.angle = static_cast<float>(kUp * angle);
  block.shift = static_cast<float>(kUp * shift);
  return block;
}

CutView cut_view(const spec::View<double>& view, const Eigen::Vector3d& centre) {
  CutView out{};
  const Eigen::Vector3d eye = view.eye - centre;
  std::copy_n(eye.data(), 3, out.eye);
  std::copy_n(view.right.data(), 3, out.right);
  std::copy_n(view.up.data(), 3, out.up);
  std::copy_n(view.forward.data(), 3, out.forward);
  return out;
}

}  // namespace nav::render
