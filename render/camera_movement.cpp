// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/camera_movement.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "nav/positions.hpp"

namespace nav::render {
namespace {

/// Unit axes of a view in the Ct frame.
struct ViewAxes {
  Eigen::Vector3d right, up, forward;
};

ViewAxes axes_of(const Camera& camera) {
  const Eigen::Vector3d forward = (camera.look_at_ct.mm - camera.eye_ct.mm).normalized();
  const Eigen::Vector3d right = forward.cross(camera.up_ct.v).normalized();
  return {right, right.cross(forward), forward};
}

// Limits of the zoom, for distances and for orthographic heights, mm.
constexpr double kNearestMm = 0.1;
constexpr double kFarthestMm = 1e5;

/// Divides a length by a factor, within the limits. A length beyond a limit goes no further.
double zoomed_length(double mm, double factor) {
  return std::clamp(mm / factor, std::min(mm, kNearestMm), std::max(mm, kFarthestMm));
}

/// The moved camera, or the old one if no scene allows the moved one.
Camera within_places(const Camera& moved, const Camera& camera) {
  return is_place(moved.eye_ct.mm) && is_place(moved.look_at_ct.mm) ? moved : camera;
}

}  // namespace

Camera orbited(const Camera& camera, double yaw_rad, double pitch_rad) {
  const ViewAxes axes = axes_of(camera);
  // The eye moves and the scene stands still. The up direction turns with the view, so that the
  // camera never crosses a pole.
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(yaw_rad, axes.up) * Eigen::AngleAxisd(-pitch_rad, axes.right))
          .toRotationMatrix();
  Camera result = camera;
  result.eye_ct.mm = camera.look_at_ct.mm + turn * (camera.eye_ct.mm - camera.look_at_ct.mm);
  result.up_ct.v = turn * axes.up;
  return within_places(result, camera);
}

Camera panned(const Camera& camera, double right, double up) {
  const ViewAxes axes = axes_of(camera);
  const double distance_mm = (camera.look_at_ct.mm - camera.eye_ct.mm).norm();
  const double height_mm = camera.orthographic
                               ? camera.orthographic_height_mm
                               : 2 * distance_mm * std::tan(0.5 * camera.vertical_fov_rad);
  const Eigen::Vector3d shift_mm = height_mm * (right * axes.right + up * axes.up);
  Camera result = camera;
  result.eye_ct.mm += shift_mm;
  result.look_at_ct.mm += shift_mm;
  return within_places(result, camera);
}

Camera zoomed(const Camera& camera, double factor) {
  NAV_CHECK(factor > 0, factor);
  Camera result = camera;
  result.orthographic_height_mm = zoomed_length(camera.orthographic_height_mm, factor);
  if (!camera.orthographic) {
    const Eigen::Vector3d back = camera.eye_ct.mm - camera.look_at_ct.mm;
    const double distance_mm = back.norm();
    result.eye_ct.mm =
        camera.look_at_ct.mm + zoomed_length(distance_mm, factor) / distance_mm * back;
  }
  return within_places(result, camera);
}

Camera looking_at(const Camera& camera, const Point<frames::Ct>& point_ct) {
  Camera result = camera;
  result.eye_ct.mm += point_ct.mm - camera.look_at_ct.mm;
  result.look_at_ct = point_ct;
  return within_places(result, camera);
}

Camera seen_from(const Camera& camera, ViewFrom side) {
  // LPS: left is +x, posterior +y, superior +z.
  const Eigen::Vector3d anterior(0, -1, 0);
  const Eigen::Vector3d head(0, 0, 1);
  Eigen::Vector3d towards_eye = anterior;
  switch (side) {
    case ViewFrom::kAnterior:
      break;
    case ViewFrom::kPosterior:
      towards_eye = -anterior;
      break;
    case ViewFrom::kLeft:
      towards_eye = Eigen::Vector3d::UnitX();
      break;
    case ViewFrom::kRight:
      towards_eye = -Eigen::Vector3d::UnitX();
      break;
    case ViewFrom::kHead:
      towards_eye = head;
      break;
    case ViewFrom::kFeet:
      towards_eye = -head;
      break;
  }
  const bool along_body = side == ViewFrom::kHead || side == ViewFrom::kFeet;
  Camera result = camera;
  const double distance_mm = (camera.eye_ct.mm - camera.look_at_ct.mm).norm();
  result.eye_ct.mm = camera.look_at_ct.mm + distance_mm * towards_eye;
  result.up_ct.v = along_body ? anterior : head;
  return within_places(result, camera);
}

Camera moved(const Camera& camera, const CameraMovement& movement) {
  // The eye moves against the drag, so that the scene moves with the mouse.
  const Eigen::Vector2d turn = -M_PI * movement.orbit;
  Camera result = orbited(camera, turn.x(), turn.y());
  result = panned(result, -movement.pan.x(), -movement.pan.y());
  return zoomed(result, movement.zoom);
}

}  // namespace nav::render
