// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "render/scene.hpp"

namespace nav::render {

/// Movement of a camera by a user. Drags are fractions of the height of the view: x right, y up.
struct CameraMovement {
  Eigen::Vector2d orbit = Eigen::Vector2d::Zero();
  Eigen::Vector2d pan = Eigen::Vector2d::Zero();
  double zoom = 1;  ///< > 0, above 1: nearer.
};

// The functions below turn a valid camera into a valid camera. A camera that would leave the
// positions that scenes allow (nav/positions.hpp) does not move. A zoom ends at 0.1 mm and at 100
// m.

/// Turns a camera about its look-at point: yaw about the view's up axis (positive: the eye moves
/// right), then pitch about its right axis (positive: the eye moves up), rad.
Camera orbited(const Camera& camera, double yaw_rad, double pitch_rad);
/// Moves eye and look-at point by fractions of the image height (right, up).
Camera panned(const Camera& camera, double right, double up);
/// Divides the distance to the look-at point, or the orthographic height, by a factor > 0.
Camera zoomed(const Camera& camera, double factor);
/// Moves a camera so that it looks at a point, about which it then turns. Direction and distance
/// stay.
Camera looking_at(const Camera& camera, const Point<frames::Ct>& point_ct);

/// Sides of the patient from which a camera looks.
enum class ViewFrom { kAnterior, kPosterior, kLeft, kRight, kHead, kFeet };
/// Turns a camera about its look-at point to a side of the patient. Head is up; from head and feet,
/// anterior is up. The distance stays.
Camera seen_from(const Camera& camera, ViewFrom side);

/// Moves a camera so that the scene follows the mouse: orbit, pan and zoom of the movement.
Camera moved(const Camera& camera, const CameraMovement& movement);

}  // namespace nav::render
