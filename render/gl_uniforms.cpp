// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl_uniforms.hpp"

#include <algorithm>
#include <cmath>

#include "render/ray_spec.hpp"

namespace nav::render {
namespace {

/// The largest multiple of the step that is in front of the volume for every ray, mm, >= 0.
double t_base_mm(const spec::View<double>& view, const VoxelGrid& grid, double step_mm) {
  const Eigen::Vector3d to_centre = grid.centre().mm - grid.origin_mm - view.eye;
  const double distance = view.orthographic ? to_centre.dot(view.forward) : to_centre.norm();
  const double front = distance - 0.5 * grid.extent_mm().norm();
  return std::max(0.0, std::floor(front / step_mm) * step_mm);
}

void set_camera(GlProgram& program, const Scene& scene) {
  const VoxelGrid& grid = scene.ct->grid();
  const auto view = spec::make_view<double>(scene.camera, scene.width, scene.height, grid);
  const double step_mm = spec::step_mm(scene.quality, grid);
  const double base_mm = t_base_mm(view, grid, step_mm);
  program.set("base_local", Eigen::Vector3d(view.eye + base_mm * view.forward));
  program.set("t_base_mm", base_mm);
  program.set("right", view.right);
  program.set("up", view.up);
  program.set("forward", view.forward);
  program.set("pixel_size", 2 * view.half_height / scene.height);
  program.set("picture_size", Eigen::Vector2d(scene.width, scene.height));
  program.set("orthographic", static_cast<int>(view.orthographic));
  program.set("step_mm", step_mm);
}

void set_volume(GlProgram& program, const VoxelGrid& grid) {
  program.set("ct", kCt);
  program.set("ct_size", Eigen::Vector3i(grid.size[0], grid.size[1], grid.size[2]));
  const Eigen::Matrix3d index_from_local =
      grid.spacing_mm.cwiseInverse().asDiagonal() * grid.directions.transpose();
  program.set("index_from_local", index_from_local);
}

void set_plane(GlProgram& program, const spec::PlaneSurface<double>& plane) {
  program.set("us_picture", kPicture);
  program.set("image_from_local", plane.image_from_local);
  program.set("image_origin", plane.origin);
  program.set("pixel_from_mm", plane.pixel_from_mm);
  program.set("grid_origin_mm", plane.grid_origin_mm);
  program.set("mm_across", plane.mm_across);
  program.set("has_outline", static_cast<int>(plane.has_outline));
  program.set("outline", Eigen::Vector4d(plane.apex_mm.x(), plane.apex_mm.y(), plane.radius_min_mm,
                                         plane.radius_max_mm));
  program.set("outline_half", Eigen::Vector2d(plane.sin_half, plane.cos_half));
  program.set("shows_picture", static_cast<int>(plane.shows_picture));
  program.set("border_rgb", plane.border_rgb);
  program.set("plane_opacity", plane.opacity);
}

void set_needle(GlProgram& program, const spec::CapsuleSurface<double>& needle) {
  program.set("needle_a", needle.a);
  program.set("needle_b", needle.b);
  program.set("needle_radius", needle.radius);
  program.set("needle_rgba",
              Eigen::Vector4d(needle.rgb.x(), needle.rgb.y(), needle.rgb.z(), needle.alpha));
}

}  // namespace

GlFeatures features_of(const Scene& scene, bool shared_depth, bool manual_filter) {
  GlFeatures features;
  features.shading = scene.shading.enabled;
  features.plane = scene.plane && scene.plane->safety.state != SafetyState::kLost;
  features.needle = scene.needle && scene.needle->safety.state != SafetyState::kLost;
  features.spheres = !scene.spheres.empty();
  features.skipping = scene.quality.skip_empty_bricks;
  features.shared_depth = shared_depth;
  features.manual_filter = manual_filter;
  return features;
}

void set_uniforms(GlProgram& program, const GlFeatures& features, const Scene& scene,
                  const GlTextures& textures, const std::optional<SharedDepth>& depth) {
  const VoxelGrid& grid = scene.ct->grid();
  set_camera(program, scene);
  set_volume(program, grid);
  const TransferTable& table = textures.table();
  program.set("transfer", kTransfer);
  program.set("transfer_first_hu", table.first_hu());
  program.set("transfer_per_hu", 1.0);
  program.set("transfer_last", table.size() - 1.0);
  constexpr double kNeverReached = 2;
  program.set("opaque_at", scene.quality.opaque_at < 1 ? scene.quality.opaque_at : kNeverReached);
  if (features.shading || features.needle || features.spheres) {
    const Shading& light = scene.shading;
    program.set("shade_light",
                Eigen::Vector4d(light.ambient, light.diffuse, light.specular, light.shininess));
  }
  if (features.shading) {
    program.set("full_gradient_per_mm", scene.shading.full_gradient_per_mm);
    program.set("half_per_spacing", Eigen::Vector3d(0.5 * grid.spacing_mm.cwiseInverse()));
  }
  if (features.skipping) {
    program.set("brick_distance", kBricks);
    program.set("brick_count", textures.brick_count());
    program.set("brick_size", static_cast<double>(kBrickVoxels));
  }
  if (features.plane) set_plane(program, *spec::make_plane<double>(*scene.plane, grid));
  if (features.needle) set_needle(program, *spec::make_needle<double>(*scene.needle, grid));
  if (features.spheres) {
    program.set("spheres", kSpheres);
    program.set("sphere_count", static_cast<int>(scene.spheres.size()));
  }
  if (features.shared_depth) {
    program.set("vtk_depth", kDepth);
    program.set("depth_rows", depth->rows);
  }
}

}  // namespace nav::render
