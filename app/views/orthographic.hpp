// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "nav/volume.hpp"
#include "render/scene.hpp"

namespace nav::app {

/// Changes a perspective camera to parallel rays. Objects at the look-at point keep their size. The
/// eye moves back, so that the whole volume lies in front of the plane where the rays begin.
inline render::Camera orthographic_of(render::Camera camera, const VoxelGrid& grid) {
  const Eigen::Vector3d back = camera.eye_ct.mm - camera.look_at_ct.mm;
  const double distance_mm = back.norm();
  camera.orthographic = true;
  camera.orthographic_height_mm = 2 * distance_mm * std::tan(camera.vertical_fov_rad / 2);
  const double reach_mm =
      0.5 * grid.extent_mm().norm() + (grid.centre().mm - camera.look_at_ct.mm).norm();
  camera.eye_ct.mm += reach_mm * back / distance_mm;
  return camera;
}

}  // namespace nav::app
