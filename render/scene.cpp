// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/scene.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>

namespace nav::render {
namespace {

template <class Value>
Error refusal(const std::string& field, const std::string& expected, const Value& found) {
  std::ostringstream text;
  text << field << ": expected " << expected << ", found " << found;
  return {ErrorCode::kMalformedData, text.str()};
}

constexpr double kMaxMm = 1e7;  // 10 km: farther is a mistake of units.

Result<void> check_place(const std::string& field, const Eigen::Vector3d& mm) {
  if (mm.allFinite() && mm.cwiseAbs().maxCoeff() <= kMaxMm) return {};
  return refusal(field, "finite numbers within 1e7 mm", mm.transpose());
}

/// low <= value <= high; refuses NaN.
Result<void> check_range(const std::string& field, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  std::ostringstream expected;
  expected << "a number in [" << low << ", " << high << "]";
  return refusal(field, expected.str(), value);
}

/// 0 < value <= high; refuses NaN and infinity.
Result<void> check_positive(const std::string& field, double value, double high) {
  if (value > 0 && value <= high) return {};
  std::ostringstream expected;
  expected << "a number in (0, " << high << "]";
  return refusal(field, expected.str(), value);
}

Result<void> check_colour(const std::string& field, const Eigen::Vector3d& rgb) {
  for (int c = 0; c < 3; ++c) {
    if (const auto ok = check_range(field, rgb[c], 0, 1); !ok) return ok;
  }
  return {};
}

/// The first refusal of a list, or none.
Result<void> first_of(std::initializer_list<Result<void>> checks) {
  for (const auto& check : checks) {
    if (!check) return check;
  }
  return {};
}

Result<void> check_camera(const Camera& camera) {
  if (const auto ok = first_of({check_place("camera.eye_ct", camera.eye_ct.mm),
                                check_place("camera.look_at_ct", camera.look_at_ct.mm),
                                check_place("camera.up_ct", camera.up_ct.v)});
      !ok) {
    return ok;
  }
  const Eigen::Vector3d forward = camera.look_at_ct.mm - camera.eye_ct.mm;
  constexpr double kMinDistanceMm = 1e-6;
  if (forward.norm() < kMinDistanceMm) {
    return refusal("camera.look_at_ct", "a point away from the eye", "a distance of 0 mm");
  }
  if (!(camera.up_ct.v.norm() > 0)) {
    return refusal("camera.up_ct", "a direction", "a zero vector");
  }
  constexpr double kMinSine = 1e-6;
  if (forward.normalized().cross(camera.up_ct.v.normalized()).norm() < kMinSine) {
    return refusal("camera.up_ct", "a direction that is not parallel to the view",
                   camera.up_ct.v.transpose());
  }
  if (camera.orthographic) {
    return check_positive("camera.orthographic_height_mm", camera.orthographic_height_mm, kMaxMm);
  }
  const double fov = camera.vertical_fov_rad;
  if (!(fov > 0 && fov < M_PI)) {
    return refusal("camera.vertical_fov_rad", "an angle in (0, pi) rad", fov);
  }
  return {};
}

Result<void> check_plane(const UltrasoundPlane& plane) {
  if (plane.safety.state == SafetyState::kLost) return {};  // Not drawn, so nothing to judge.
  const UltrasoundFrame& frame = plane.frame;
  if (frame.pixels.empty()) {
    return refusal("plane.frame.pixels", "a picture",
                   std::to_string(frame.pixels.width()) + " x " +
                       std::to_string(frame.pixels.height()) + " pixels");
  }
  if (const auto ok = check_place("plane.ct_from_image", plane.ct_from_image.translation_mm());
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
    return refusal("plane.frame.outline.apex_mm", "finite numbers", sector.apex_mm.transpose());
  }
  return first_of(
      {check_range("plane.frame.outline.radius_min_mm", sector.radius_min_mm, 0, kMaxMm),
       check_range("plane.frame.outline.radius_max_mm", sector.radius_max_mm, sector.radius_min_mm,
                   kMaxMm),
       check_positive("plane.frame.outline.half_angle_rad", sector.half_angle_rad, M_PI / 2)});
}

Result<void> check_needle(const NeedleShape& needle) {
  if (needle.safety.state == SafetyState::kLost) return {};
  if (const auto ok = first_of({check_place("needle.tip_ct", needle.tip_ct.mm),
                                check_place("needle.hub_ct", needle.hub_ct.mm),
                                check_positive("needle.radius_mm", needle.radius_mm, kMaxMm),
                                check_colour("needle.rgb", needle.rgb)});
      !ok) {
    return ok;
  }
  constexpr double kMinLengthMm = 1e-3;
  const double length = (needle.tip_ct.mm - needle.hub_ct.mm).norm();
  if (length < kMinLengthMm) {
    return refusal("needle.hub_ct", "a hub at least 0.001 mm from the tip", length);
  }
  return {};
}

Result<void> check_spheres(const std::vector<SphereShape>& spheres) {
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const std::string name = "spheres[" + std::to_string(i) + "]";
    const SphereShape& sphere = spheres[i];
    if (const auto ok = first_of({check_place(name + ".centre_ct", sphere.centre_ct.mm),
                                  check_positive(name + ".radius_mm", sphere.radius_mm, kMaxMm),
                                  check_colour(name + ".rgb", sphere.rgb),
                                  check_positive(name + ".opacity", sphere.opacity, 1)});
        !ok) {
      return ok;
    }
  }
  return {};
}

Result<void> check_shading(const Shading& s) {
  constexpr double kMaxWeight = 10;
  constexpr double kMaxShininess = 1000;
  return first_of({check_range("shading.ambient", s.ambient, 0, kMaxWeight),
                   check_range("shading.diffuse", s.diffuse, 0, kMaxWeight),
                   check_range("shading.specular", s.specular, 0, kMaxWeight),
                   check_range("shading.shininess", s.shininess, 0, kMaxShininess)});
}

}  // namespace

Result<void> validate(const Scene& scene) {
  if (!scene.ct) return refusal("ct", "a volume", "none");
  if (const auto ok = check_place("ct.grid.origin_mm", scene.ct->grid().origin_mm); !ok) return ok;
  constexpr double kMaxPixels = 16384;
  if (const auto ok = first_of({check_range("width", scene.width, 1, kMaxPixels),
                                check_range("height", scene.height, 1, kMaxPixels)});
      !ok) {
    return ok;
  }
  if (const auto ok =
          first_of({check_camera(scene.camera), check_shading(scene.shading),
                    check_range("quality.step_voxels", scene.quality.step_voxels, 1.0 / 64.0, 16),
                    check_positive("quality.opaque_at", scene.quality.opaque_at, 1),
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
  return check_spheres(scene.spheres);
}

}  // namespace nav::render
