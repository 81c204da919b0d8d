// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "nav/matrices.hpp"
#include "nav/positions.hpp"
#include "render/two_volumes.hpp"

namespace nav::render {
namespace {

template <class Value>
Error rejection(const std::string& field, const std::string& expected, const Value& found) {
  std::ostringstream text;
  text << field << ": expected " << expected << ", found " << found;
  return {ErrorCode::kMalformedData, text.str()};
}

Result<void> check_position(const std::string& field, const Eigen::Vector3d& mm) {
  if (is_place(mm)) return {};
  return rejection(field, "finite numbers within 1e7 mm", mm.transpose());
}

/// Checks low <= value <= high; rejects NaN.
Result<void> check_range(const std::string& field, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  std::ostringstream expected;
  expected << "a number in [" << low << ", " << high << "]";
  return rejection(field, expected.str(), value);
}

/// Checks 0 < value <= high; rejects NaN and infinity.
Result<void> check_positive(const std::string& field, double value, double high) {
  if (value > 0 && value <= high) return {};
  std::ostringstream expected;
  expected << "a number in (0, " << high << "]";
  return rejection(field, expected.str(), value);
}

Result<void> check_colour(const std::string& field, const Eigen::Vector3d& rgb) {
  for (int c = 0; c < 3; ++c) {
    if (const auto ok = check_range(field, rgb[c], 0, 1); !ok) return ok;
  }
  return {};
}

/// The first error of a list, or none.
Result<void> first_of(std::initializer_list<Result<void>> checks) {
  for (const auto& check : checks) {
    if (!check) return check;
  }
  return {};
}

Result<void> check_camera(const Camera& camera) {
  if (const auto ok = first_of({check_position("camera.eye_ct", camera.eye_ct.mm),
                                check_position("camera.look_at_ct", camera.look_at_ct.mm),
                                check_position("camera.up_ct", camera.up_ct.v)});
      !ok) {
    return ok;
  }
  const Eigen::Vector3d forward = camera.look_at_ct.mm - camera.eye_ct.mm;
  constexpr double kMinDistanceMm = 1e-6;
  if (forward.norm() < kMinDistanceMm) {
    return rejection("camera.look_at_ct", "a point away from the eye", "a distance of 0 mm");
  }
  if (!(camera.up_ct.v.norm() > 0)) {
    return rejection("camera.up_ct", "a direction", "a zero vector");
  }
  constexpr double kMinSine = 1e-6;
  if (forward.normalized().cross(camera.up_ct.v.normalized()).norm() < kMinSine) {
    return rejection("camera.up_ct", "a direction that is not parallel to the view",
                     camera.up_ct.v.transpose());
  }
  if (camera.orthographic) {
    return check_positive("camera.orthographic_height_mm", camera.orthographic_height_mm,
                          kFurthestMm);
  }
  const double fov = camera.vertical_fov_rad;
  if (!(fov > 0 && fov < M_PI)) {
    return rejection("camera.vertical_fov_rad", "an angle in (0, pi) rad", fov);
  }
  return {};
}

Result<void> check_plane(const UltrasoundPlane& plane) {
  if (plane.safety.state == SafetyState::kLost) return {};  // Not drawn, so not checked.
  const UltrasoundImage& frame = plane.frame;
  if (frame.pixels.empty()) {
    return rejection("plane.frame.pixels", "an image",
                     std::to_string(frame.pixels.width()) + " x " +
                         std::to_string(frame.pixels.height()) + " pixels");
  }
  if (const auto ok = check_position("plane.ct_from_image", plane.ct_from_image.translation_mm());
      !ok) {
    return ok;
  }
  if (const auto ok = validate(frame.grid); !ok) {
    return Error{ok.error().code, "plane.frame: " + ok.error().message};
  }
  if (const auto ok = check_positive("plane.opacity", plane.opacity, 1); !ok) return ok;
  if (!frame.outline) return {};
  const SectorOutline& sector = *frame.outline;
  if (!sector.apex_mm.allFinite()) {
    return rejection("plane.frame.outline.apex_mm", "finite numbers", sector.apex_mm.transpose());
  }
  return first_of(
      {check_range("plane.frame.outline.radius_min_mm", sector.radius_min_mm, 0, kFurthestMm),
       check_range("plane.frame.outline.radius_max_mm", sector.radius_max_mm, sector.radius_min_mm,
                   kFurthestMm),
       check_positive("plane.frame.outline.half_angle_rad", sector.half_angle_rad, M_PI / 2)});
}

Result<void> check_needle(const NeedleShape& needle) {
  if (needle.safety.state == SafetyState::kLost) return {};
  if (const auto ok = first_of({check_position("needle.tip_ct", needle.tip_ct.mm),
                                check_position("needle.hub_ct", needle.hub_ct.mm),
                                check_positive("needle.radius_mm", needle.radius_mm, kFurthestMm),
                                check_colour("needle.rgb", needle.rgb)});
      !ok) {
    return ok;
  }
  constexpr double kMinLengthMm = 1e-3;
  const double length = (needle.tip_ct.mm - needle.hub_ct.mm).norm();
  if (length < kMinLengthMm) {
    return rejection("needle.hub_ct", "a hub at least 0.001 mm from the tip", length);
  }
  return {};
}

Result<void> check_spheres(const std::vector<SphereShape>& spheres) {
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const std::string name = "spheres[" + std::to_string(i) + "]";
    const SphereShape& sphere = spheres[i];
    if (const auto ok =
            first_of({check_position(name + ".centre_ct", sphere.centre_ct.mm),
                      check_positive(name + ".radius_mm", sphere.radius_mm, kFurthestMm),
                      check_colour(name + ".rgb", sphere.rgb),
                      check_positive(name + ".opacity", sphere.opacity, 1)});
        !ok) {
      return ok;
    }
  }
  return {};
}

Result<void> check_lines(const std::vector<LineShape>& lines) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string name = "lines[" + std::to_string(i) + "]";
    const LineShape& line = lines[i];
    if (const auto ok = first_of({check_position(name + ".from_ct", line.from_ct.mm),
                                  check_position(name + ".to_ct", line.to_ct.mm),
                                  check_positive(name + ".radius_mm", line.radius_mm, kFurthestMm),
                                  check_colour(name + ".rgb", line.rgb),
                                  check_positive(name + ".opacity", line.opacity, 1)});
        !ok) {
      return ok;
    }
  }
  return {};
}

/// The largest distance of the vertices from their common plane, mm. The plane goes through their
/// mean at right angles to the axis of their least extent. This is also defined for vertices in a
/// line and for folded outlines.
double flatness_mm(const std::vector<Point<frames::Ct>>& vertices) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& vertex : vertices) mean += vertex.mm / static_cast<double>(vertices.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& vertex : vertices) {
    spread += (vertex.mm - mean) * (vertex.mm - mean).transpose();
  }
  const Eigen::Vector3d normal = eigenpairs<3>(spread).vectors.col(0);
  double worst = 0;
  for (const auto& vertex : vertices) {
    worst = std::max(worst, std::abs(normal.dot(vertex.mm - mean)));
  }
  return worst;
}

Result<void> check_polygon(const std::string& name, const PolygonObject& polygon) {
  constexpr std::size_t kMaxVertices = 256;
  const std::size_t count = polygon.vertices_ct.size();
  if (count < 2 || count > kMaxVertices) return rejection(name, "2 to 256 vertices", count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string vertex = name + ".vertices_ct[" + std::to_string(i) + "]";
    if (const auto ok = check_position(vertex, polygon.vertices_ct[i].mm); !ok) return ok;
  }
  constexpr double kFlatMm = 0.01;
  const double off = flatness_mm(polygon.vertices_ct);
  if (off > kFlatMm) return rejection(name, "vertices in one plane within 0.01 mm", off);
  return {};
}

Result<void> check_box(const std::string& name, const BoxObject& box) {
  if (const auto ok = check_position(name + ".centre_ct", box.centre_ct.mm); !ok) return ok;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d edge = box.half_edges_ct.col(axis);
    if (const auto ok = check_position(name + ".half_edges_ct", edge); !ok) return ok;
    if (!(edge.norm() > 0)) return rejection(name + ".half_edges_ct", "edges longer than 0", 0);
    const Eigen::Vector3d next = box.half_edges_ct.col((axis + 1) % 3);
    constexpr double kMaxCosine = 1e-6;
    const double cosine = edge.dot(next) / (edge.norm() * next.norm());
    if (std::abs(cosine) > kMaxCosine) {
      return rejection(name + ".half_edges_ct", "edges at right angles", cosine);
    }
  }
  return {};
}

Result<void> check_mesh(const std::string& name, const std::shared_ptr<const MeshObject>& mesh) {
  if (!mesh || mesh->triangles.empty()) return rejection(name, "at least one triangle", "none");
  const auto count = static_cast<int>(mesh->vertices_ct.size());
  const std::string vertices = name + ".vertices_ct";
  for (const auto& vertex : mesh->vertices_ct) {
    if (const auto ok = check_position(vertices, vertex.mm); !ok) return ok;
  }
  for (const auto& triangle : mesh->triangles) {
    for (const int i : triangle) {
      if (i >= 0 && i < count) continue;
      return rejection(name + ".triangles", "indices of " + std::to_string(count) + " vertices", i);
    }
  }
  return {};
}

Result<void> check_cutaway(const Cutaway& cutaway) {
  if (const auto ok =
          first_of({check_positive("cutaway.theta1_rad", cutaway.theta1_rad, M_PI / 2),
                    check_positive("cutaway.theta2_rad", cutaway.theta2_rad, M_PI / 2)});
      !ok) {
    return ok;
  }
  if (!(cutaway.theta2_rad < M_PI / 2)) {
    return rejection("cutaway.theta2_rad", "an angle below pi/2 rad", cutaway.theta2_rad);
  }
  if (cutaway.theta1_rad > cutaway.theta2_rad) {
    std::ostringstream expected;
    expected << "at most theta2_rad, " << cutaway.theta2_rad;
    return rejection("cutaway.theta1_rad", expected.str(), cutaway.theta1_rad);
  }
  if (!(cutaway.overlay_mm >= 0)) {
    return rejection("cutaway.overlay_mm", "a thickness >= 0 mm", cutaway.overlay_mm);
  }
  if (cutaway.constant) {
    const auto& tau = *cutaway.constant;
    if (!(tau.lower >= 0 && tau.upper <= 1 && tau.lower < tau.upper)) {
      std::ostringstream found;
      found << tau.lower << " and " << tau.upper;
      return rejection("cutaway.constant", "0 <= lower < upper <= 1", found.str());
    }
  }
  for (std::size_t i = 0; i < cutaway.polygons.size(); ++i) {
    const std::string name = "cutaway.polygons[" + std::to_string(i) + "]";
    if (const auto ok = check_polygon(name, cutaway.polygons[i]); !ok) return ok;
  }
  for (std::size_t i = 0; i < cutaway.boxes.size(); ++i) {
    const std::string name = "cutaway.boxes[" + std::to_string(i) + "]";
    if (const auto ok = check_box(name, cutaway.boxes[i]); !ok) return ok;
  }
  for (std::size_t i = 0; i < cutaway.meshes.size(); ++i) {
    const std::string name = "cutaway.meshes[" + std::to_string(i) + "]";
    if (const auto ok = check_mesh(name, cutaway.meshes[i]); !ok) return ok;
  }
  return {};
}

bool equal_grids(const VoxelGrid& a, const VoxelGrid& b) {
  return a.size == b.size && a.spacing_mm == b.spacing_mm && a.origin_mm == b.origin_mm &&
         a.directions == b.directions;
}

Result<void> check_ultrasound(const Scene& scene) {
  const UltrasoundVolume& ultrasound = *scene.ultrasound;
  if (!ultrasound.volume) return rejection("ultrasound.volume", "a volume", "none");
  if (scene.predicates) {
    return rejection("ultrasound", "no predicates of the CT together with it", "both");
  }
  if (const auto ok = first_of(
          {check_position("ultrasound.volume.grid.origin_mm", ultrasound.volume->grid().origin_mm),
           check_range("ultrasound.ct_importance", ultrasound.ct_importance, 0, 1024)});
      !ok) {
    return ok;
  }
  const auto ok = validate(ultrasound.predicates, ultrasound_scene(scene));
  return ok ? ok : Error{ok.error().code, "ultrasound." + ok.error().message};
}

}  // namespace

Result<void> validate(const Shading& s) {
  constexpr double kMaxWeight = 10;
  constexpr double kMaxShininess = 1000;
  return first_of({check_range("shading.emphasis", s.emphasis, 0, 1),
                   check_positive("shading.full_gradient_per_mm", s.full_gradient_per_mm, 1e6),
                   check_range("shading.cool_share", s.cool_share, 0, 1),
                   check_range("shading.warm_share", s.warm_share, 0, 1),
                   check_range("shading.silhouette", s.silhouette, 0, 1),
                   check_range("shading.ambient", s.ambient, 0, kMaxWeight),
                   check_range("shading.diffuse", s.diffuse, 0, kMaxWeight),
                   check_range("shading.specular", s.specular, 0, kMaxWeight),
                   check_range("shading.shininess", s.shininess, 0, kMaxShininess)});
}

Result<void> validate(const Scene& scene) {
  if (!scene.ct) return rejection("ct", "a volume", "none");
  if (const auto ok = check_position("ct.grid.origin_mm", scene.ct->grid().origin_mm); !ok)
    return ok;
  if (scene.gradient_source && !equal_grids(scene.gradient_source->grid(), scene.ct->grid())) {
    return rejection("gradient_source", "the grid of the CT", "another");
  }
  constexpr double kMaxPixels = 16384;
  if (const auto ok = first_of({check_range("width", scene.width, 1, kMaxPixels),
                                check_range("height", scene.height, 1, kMaxPixels)});
      !ok) {
    return ok;
  }
  if (const auto ok =
          first_of({check_camera(scene.camera), validate(scene.shading),
                    check_range("quality.step_voxels", scene.quality.step_voxels, 1.0 / 64.0, 16),
                    check_positive("quality.opaque_at", scene.quality.opaque_at, 1),
                    check_range("quality.pixel_error", scene.quality.pixel_error, 0, 1),
                    check_range("grey.level_hu", scene.grey.level_hu, -1e6, 1e6),
                    check_positive("grey.width_hu", scene.grey.width_hu, 1e6),
                    check_colour("background_rgb", scene.background_rgb)});
      !ok) {
    return ok;
  }
  if (scene.plane) {
    if (const auto ok = check_plane(*scene.plane); !ok) return ok;
  }
  if (scene.needle) {
    if (const auto ok = check_needle(*scene.needle); !ok) return ok;
  }
  if (scene.cutaway) {
    if (const auto ok = check_cutaway(*scene.cutaway); !ok) return ok;
  }
  if (const auto ok = check_spheres(scene.spheres); !ok) return ok;
  if (const auto ok = check_lines(scene.lines); !ok) return ok;
  if (scene.ultrasound) {
    if (const auto ok = check_ultrasound(scene); !ok) return ok;
  }
  return scene.predicates ? validate(*scene.predicates, scene) : Result<void>{};
}

}  // namespace nav::render
