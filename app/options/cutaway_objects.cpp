// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/cutaway_objects.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>

#include "io/surface_file.hpp"
#include "session/outside_ct.hpp"

namespace nav::app {
namespace {

using Vec3 = Eigen::Vector3d;
using Vertices = std::vector<Vec3>;
constexpr double kMaxMm = 1e6;

template <class Found>
Error rejected_object(const std::string& name, const std::string& expected, const Found& found) {
  std::ostringstream text;
  text << name << ": expected " << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

/// Twice the area, along the normal (Newell), exact for flat polygons in any place.
Vec3 doubled_area(const Vertices& vertices) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < vertices.size(); ++i) {
    sum += (vertices[i] - vertices[0]).cross(vertices[i + 1] - vertices[0]);
  }
  return sum;
}

/// True if two edges of a flat polygon meet, ends included.
bool edges_meet(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& normal) {
  const auto side = [&](const Vec3& p, const Vec3& q, const Vec3& r) {
    return (q - p).cross(r - p).dot(normal);
  };
  const auto apart = [](double s, double t) { return (s > 0 && t > 0) || (s < 0 && t < 0); };
  if (apart(side(a, b, c), side(a, b, d)) || apart(side(c, d, a), side(c, d, b))) return false;
  // All in one line: apart where their boxes are.
  const Eigen::AlignedBox3d one(a.cwiseMin(b), a.cwiseMax(b));
  const Eigen::AlignedBox3d other(c.cwiseMin(d), c.cwiseMax(d));
  return one.intersects(other);
}

Result<void> validate_polygon(const std::string& name, const Vertices& vertices) {
  const std::size_t count = vertices.size();
  if (count < 3 || count > 256) return rejected_object(name, "3 to 256 vertices", count);
  for (const Vec3& v : vertices) {
    if (!(v.norm() <= kMaxMm)) return rejected_object(name, "places within 10^6 mm", v.transpose());
  }
  const Vec3 area = doubled_area(vertices);
  constexpr double kLeastMm2 = 1e-3;
  // A bow tie has none either; it is the crossing that the user should look for.
  const Vec3 normal =
      area.norm() > kLeastMm2
          ? Vec3(area.normalized())
          : Vec3((vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]).normalized());
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 2; j < count; ++j) {
      if (i == 0 && j + 1 == count) continue;  // Neighbours.
      if (edges_meet(vertices[i], vertices[i + 1], vertices[j], vertices[(j + 1) % count],
                     normal)) {
        return rejected_object(
            name, "a polygon that does not cross or touch itself",
            "edges " + std::to_string(i) + " and " + std::to_string(j) + " that do");
      }
    }
  }
  if (!(area.norm() > kLeastMm2)) return rejected_object(name, "an area", area.norm() / 2);
  constexpr double kFlatMm = 0.01;  // Limit of render::PolygonObject.
  for (const Vec3& v : vertices) {
    const double off = std::abs((v - vertices[0]).dot(normal));
    if (off > kFlatMm) return rejected_object(name, "vertices in one plane within 0.01 mm", off);
  }
  return {};
}

Result<void> validate_box(const std::string& name, const CutawayObject& box) {
  if (!(box.centre_ct.norm() <= kMaxMm)) {
    return rejected_object(name + ".centre_mm", "a position within 10^6 mm",
                           box.centre_ct.transpose());
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 edge = box.half_edges_ct.col(axis);
    const Vec3 next = box.half_edges_ct.col((axis + 1) % 3);
    if (!(edge.norm() > 1e-3 && edge.norm() <= kMaxMm)) {
      return rejected_object(name + ".half_edges_mm", "edges of 0.001 to 10^6 mm", edge.norm());
    }
    constexpr double kMaxCosine = 1e-6;  // Limit of render::BoxObject.
    const double cosine = edge.dot(next) / (edge.norm() * next.norm());
    if (std::abs(cosine) > kMaxCosine) {
      return rejected_object(name + ".half_edges_mm", "edges at right angles", cosine);
    }
  }
  return {};
}

Result<std::shared_ptr<const render::MeshObject>> read_mesh(const std::filesystem::path& file) {
  const auto read = io::read_surface(file);
  if (!read) return read.error();
  const auto malformed = [&](const std::string& expected, const std::string& found) {
    return Error{ErrorCode::kMalformedData,
                 file.string() + ": expected " + expected + ", found " + found};
  };
  auto mesh = std::make_shared<render::MeshObject>();
  for (const Vec3& p : read->points_mm) {
    if (!(p.norm() <= kMaxMm)) {
      std::ostringstream found;
      found << p.transpose();
      return malformed("vertices within 10^6 mm", found.str());
    }
    mesh->vertices_ct.push_back({p});
  }
  double area_mm2 = 0;
  for (const auto& [a, b, c] : read->triangles) {
    const auto at = [&](int i) -> const Vec3& {
      return read->points_mm[static_cast<std::size_t>(i)];
    };
    area_mm2 += 0.5 * (at(b) - at(a)).cross(at(c) - at(a)).norm();
  }
  if (!(area_mm2 > 1e-3)) return malformed("a surface with an area", "none");
  mesh->triangles = read->triangles;
  return std::shared_ptr<const render::MeshObject>(std::move(mesh));
}

}  // namespace

Result<void> validate(const std::vector<CutawayObject>& objects) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::string name = "cutaway_objects[" + std::to_string(i) + "]";
    const CutawayObject& object = objects[i];
    Result<void> ok;
    if (object.type == CutawayObject::Type::kBox) ok = validate_box(name, object);
    if (object.type == CutawayObject::Type::kPolygon) {
      ok = validate_polygon(name + ".vertices_mm", object.vertices_ct);
    }
    if (object.type == CutawayObject::Type::kMesh && object.file.empty()) {
      ok = rejected_object(name + ".file", "a surface file", "none");
    }
    if (!ok) return ok;
  }
  return {};
}

Result<CutawayShapes> read_cutaway_objects(const std::vector<CutawayObject>& objects,
                                           const Volume& ct, Diagnostics& diagnostics) {
  if (const auto ok = validate(objects); !ok) return ok.error();
  CutawayShapes shapes;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const CutawayObject& object = objects[i];
    std::string name = "cutaway_objects[" + std::to_string(i) + "]";
    std::vector<Point<frames::Ct>> points;
    switch (object.type) {
      case CutawayObject::Type::kBox: {
        for (int corner = 0; corner < 8; ++corner) {
          const Vec3 sides(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
          points.push_back({object.centre_ct + object.half_edges_ct * sides});
        }
        shapes.boxes.push_back({{object.centre_ct}, object.half_edges_ct});
        break;
      }
      case CutawayObject::Type::kPolygon: {
        render::PolygonObject polygon;
        for (const Vec3& v : object.vertices_ct) polygon.vertices_ct.push_back({v});
        points = polygon.vertices_ct;
        shapes.polygons.push_back(std::move(polygon));
        break;
      }
      case CutawayObject::Type::kMesh: {
        auto mesh = read_mesh(object.file);
        if (!mesh) return mesh.error();
        points = (*mesh)->vertices_ct;
        shapes.meshes.push_back(std::move(*mesh));
        name = object.file.string();
        break;
      }
    }
    session::warn_outside(name, points, 0, ct, diagnostics);
  }
  return shapes;
}

}  // namespace nav::app
