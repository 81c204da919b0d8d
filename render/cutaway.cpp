// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/spec/ray_spec_cutaway.hpp"

namespace nav::render::spec {
namespace {

using Points = std::vector<Vec3<double>>;

bool drawn(const Safety& safety) { return safety.state != SafetyState::kLost; }

Points box_face(const BoxObject& box, int axis, double side, const Eigen::Vector3d& origin) {
  const Eigen::Vector3d centre = box.centre_ct.mm - origin + side * box.half_edges_ct.col(axis);
  const Eigen::Vector3d u = box.half_edges_ct.col((axis + 1) % 3);
  const Eigen::Vector3d v = box.half_edges_ct.col((axis + 2) % 3);
  return {centre - u - v, centre + u - v, centre + u + v, centre - u + v};
}

}  // namespace

/// Computes the normal by Newell's sum, which does not need three vertices in general position.
CutawayPolygon<double> make_polygon(std::vector<Vec3<double>> vertices) {
  CutawayPolygon<double> polygon;
  polygon.normal = Vec3<double>::Zero();
  polygon.axis_u = polygon.axis_v = Vec3<double>::Zero();
  for (std::size_t i = 0, j = vertices.size() - 1; i < vertices.size(); j = i++) {
    polygon.normal += (vertices[j] - vertices[0]).cross(vertices[i] - vertices[0]);
  }
  const double area = polygon.normal.norm();
  constexpr double kNoArea = 1e-9;  // mm².
  if (vertices.size() > 2 && area > kNoArea) {
    polygon.normal /= area;
    polygon.axis_u = polygon.normal.unitOrthogonal();
    polygon.axis_v = polygon.normal.cross(polygon.axis_u);
  } else {
    polygon.normal.setZero();  // A segment, or vertices in a line: only the edges count.
  }
  polygon.vertices = std::move(vertices);
  return polygon;
}

std::vector<Vec2<double>> outline_of(const UltrasoundImage& frame) {
  if (!frame.outline) {
    std::vector<Vec2<double>> corners;
    const double right = frame.pixels.width() - 0.5;
    const double bottom = frame.pixels.height() - 0.5;
    for (const Vec2<double>& pixel : {Vec2<double>(-0.5, -0.5), Vec2<double>(right, -0.5),
                                      Vec2<double>(right, bottom), Vec2<double>(-0.5, bottom)}) {
      corners.push_back(frame.grid.origin_mm + frame.grid.mm_per_pixel * pixel);
    }
    return corners;
  }
  const SectorOutline& sector = *frame.outline;
  std::vector<Vec2<double>> outline;
  const auto add_arc = [&](double radius, double from, double to) {
    for (int i = 0; i <= kSectorChords; ++i) {
      const double angle = from + (to - from) * i / kSectorChords;
      outline.push_back(sector.apex_mm + radius * Vec2<double>(std::sin(angle), std::cos(angle)));
    }
  };
  const double half = sector.half_angle_rad;
  add_arc(sector.radius_max_mm, -half, half);
  if (sector.radius_min_mm > 0) {
    add_arc(sector.radius_min_mm, half, -half);
  } else {
    outline.push_back(sector.apex_mm);
  }
  return outline;
}

CutawayObjects<double> make_cutaway(const Scene& scene, bool with_meshes) {
  CutawayObjects<double> objects{
      .cot1 = 0, .cot2 = 0, .overlay_mm = 0, .polygons = {}, .balls = {}};
  if (!scene.cutaway || scene.projection != Projection::kComposite) return objects;
  const Cutaway& cutaway = *scene.cutaway;
  const Eigen::Vector3d origin = scene.ct->grid().origin_mm;
  objects.cot1 = 1 / std::tan(cutaway.theta1_rad);
  objects.cot2 = 1 / std::tan(cutaway.theta2_rad);
  objects.overlay_mm = cutaway.overlay_mm;
  if (cutaway.around_plane && scene.plane && drawn(scene.plane->safety)) {
    Points vertices;
    for (const Vec2<double>& p : outline_of(scene.plane->frame)) {
      const Point<frames::Image> image{{p.x(), p.y(), 0}};
      vertices.push_back((scene.plane->ct_from_image * image).mm - origin);
    }
    objects.polygons.push_back(make_polygon(std::move(vertices)));
  }
  if (cutaway.around_needle && scene.needle && drawn(scene.needle->safety)) {
    objects.polygons.push_back(
        make_polygon({scene.needle->tip_ct.mm - origin, scene.needle->hub_ct.mm - origin}));
  }
  if (cutaway.around_spheres) {
    for (const SphereShape& sphere : scene.spheres) {
      objects.balls.push_back({sphere.centre_ct.mm - origin, sphere.radius_mm});
    }
  }
  for (const PolygonObject& polygon : cutaway.polygons) {
    Points vertices;
    for (const auto& vertex : polygon.vertices_ct) vertices.push_back(vertex.mm - origin);
    objects.polygons.push_back(make_polygon(std::move(vertices)));
  }
  for (const BoxObject& box : cutaway.boxes) {
    for (int axis = 0; axis < 3; ++axis) {
      objects.polygons.push_back(make_polygon(box_face(box, axis, -1, origin)));
      objects.polygons.push_back(make_polygon(box_face(box, axis, +1, origin)));
    }
  }
  for (const auto& mesh : cutaway.meshes) {
    if (!with_meshes && mesh->triangles.size() > kExactTriangles) continue;
    for (const auto& triangle : mesh->triangles) {
      Points vertices;
      for (const int i : triangle) {
        vertices.push_back(mesh->vertices_ct[static_cast<std::size_t>(i)].mm - origin);
      }
      objects.polygons.push_back(make_polygon(std::move(vertices)));
    }
  }
  return objects;
}

}  // namespace nav::render::spec
