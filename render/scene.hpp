// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "nav/safety.hpp"
#include "nav/ultrasound_frame.hpp"
#include "nav/volume.hpp"
#include "render/transfer_function.hpp"

namespace nav::render {

/// View of the scene. Right-handed: x right, y up, looking along -z of the view.
struct Camera {
  Point<frames::Ct> eye_ct;
  Point<frames::Ct> look_at_ct;
  Direction<frames::Ct> up_ct;    ///< Need not be orthogonal to the view; not parallel.
  double vertical_fov_rad = 0.5;  ///< Perspective, in (0, pi).
  bool orthographic = false;
  double orthographic_height_mm = 300;  ///< Height of the picture when orthographic.
};

/// Blinn–Phong with a headlight at the eye, on the central-difference gradient at one voxel.
struct Shading {
  bool enabled = true;  ///< Off: no gradient is ever fetched.
  double ambient = 0.3;
  double diffuse = 0.7;
  double specular = 0.2;
  double shininess = 20;
};

/// The live picture inside the CT. Its state decides how it is drawn: valid and degraded show the
/// picture with a green or amber border; stale shows only a grey border; lost shows nothing.
struct UltrasoundPlane {
  UltrasoundFrame frame;
  Transform<frames::Ct, frames::Image> ct_from_image;
  double opacity = 1.0;  ///< Of the whole picture, (0, 1].
  Safety safety;
};

/// A straight needle, drawn as an opaque capsule of a radius; ghosted (40 % opacity) when stale,
/// absent when lost.
struct NeedleShape {
  Point<frames::Ct> tip_ct;
  Point<frames::Ct> hub_ct;
  double radius_mm = 0.8;
  Eigen::Vector3d rgb{0.95, 0.95, 1.0};
  Safety safety;
};

/// Target lesion, entry point, margin.
struct SphereShape {
  Point<frames::Ct> centre_ct;
  double radius_mm = 5;
  Eigen::Vector3d rgb{1.0, 0.8, 0.1};
  double opacity = 1.0;  ///< Of the front surface, (0, 1].
};

/// Run time against error.
struct Quality {
  double step_voxels = 0.5;       ///< Sampling distance in units of the smallest spacing.
  double opaque_at = 0.996;       ///< Early ray termination when opacity reaches it; 1: never.
  bool skip_empty_bricks = true;  ///< Bit-identical on and off.
};

/// Everything that a picture shows, and nothing of how. A plain value.
struct Scene {
  std::shared_ptr<const Volume> ct;  ///< Required.
  TransferFunction transfer;
  Shading shading;
  std::optional<UltrasoundPlane> plane;
  std::optional<NeedleShape> needle;
  std::vector<SphereShape> spheres;
  Camera camera;
  Quality quality;
  Eigen::Vector3d background_rgb{0, 0, 0};
  int width = 800;
  int height = 600;
};

/// Refuses, naming the field: no CT, picture sizes outside [1, 16384], a degenerate camera, NaN
/// anywhere, steps outside [1/64, 16], a plane whose grid is invalid.
Result<void> validate(const Scene& scene);

}  // namespace nav::render
