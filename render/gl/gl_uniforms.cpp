// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_uniforms.hpp"

#include <algorithm>
#include <cmath>

#include "render/cutaway_mesh.hpp"
#include "render/quality/sparse_rays.hpp"
#include "render/spec/ray_spec.hpp"
#include "render/two_volumes.hpp"

namespace nav::render {
namespace {

spec::View<double> view_of(const Scene& scene, const VoxelGrid& grid) {
  return spec::make_view<double>(scene.camera, scene.width, scene.height, grid);
}

/// Least distance of a volume from the eye, mm.
double front_mm(const Scene& scene, const VoxelGrid& grid) {
  const auto view = view_of(scene, grid);
  const Eigen::Vector3d to_centre = grid.centre().mm - grid.origin_mm - view.eye;
  const double distance = view.orthographic ? to_centre.dot(view.forward) : to_centre.norm();
  return distance - 0.5 * grid.extent_mm().norm();
}

/// The largest multiple of the step (with two volumes: of two slabs) that lies in front of the
/// volume for every ray, mm, >= 0.
double t_base_mm(const Scene& scene) {
  double front = front_mm(scene, scene.ct->grid());
  double unit = spec::step_mm(scene.quality, scene.ct->grid());
  if (has_two_volumes(scene)) {
    front = std::min(front, front_mm(scene, scene.ultrasound->volume->grid()));
    unit = 2 * slab_mm(scene);
  }
  return std::max(0.0, std::floor(front / unit) * unit);
}

void set_camera(GlProgram& program, const Scene& scene) {
  const VoxelGrid& grid = scene.ct->grid();
  const auto view = view_of(scene, grid);
  const double step_mm = spec::step_mm(scene.quality, grid);
  const double base_mm = t_base_mm(scene);
  program.set("base_local", Eigen::Vector3d(view.eye + base_mm * view.forward));
  program.set("t_base_mm", base_mm);
  program.set("right", view.right);
  program.set("up", view.up);
  program.set("forward", view.forward);
  program.set("pixel_size", 2 * view.half_height / scene.height);
  program.set("image_size", Eigen::Vector2d(scene.width, scene.height));
  program.set("orthographic", static_cast<int>(view.orthographic));
  program.set("step_mm", step_mm);
  if (scene.quality.jitter) program.set("image_height", static_cast<double>(scene.height));
}

void set_volume(GlProgram& program, const VoxelGrid& grid, int unit,
                const std::string& prefix = {}) {
  program.set(prefix + "ct", unit);
  program.set(prefix + "ct_size", Eigen::Vector3i(grid.size[0], grid.size[1], grid.size[2]));
  const Eigen::Matrix3d index_from_local =
      grid.spacing_mm.cwiseInverse().asDiagonal() * grid.directions.transpose();
  program.set(prefix + "index_from_local", index_from_local);
}

/// Sets what shaders/two_volumes.frag needs in addition to the uniforms of CT and predicates.
void set_two_volumes(GlProgram& program, const Scene& scene) {
  const VoxelGrid& second = scene.ultrasound->volume->grid();
  const double base_mm = t_base_mm(scene);
  const auto phase = [&](double step_mm) {
    const double cells = base_mm / step_mm;
    return cells - std::floor(cells);
  };
  const double step_mm = spec::step_mm(scene.quality, second);
  const auto view = view_of(scene, second);
  set_volume(program, second, kSecondVolume, kSecond);
  program.set("second_base_local", Eigen::Vector3d(view.eye + base_mm * view.forward));
  program.set("second_step_mm", step_mm);
  program.set("second_lattice_phase", phase(step_mm));
  program.set("lattice_phase", phase(spec::step_mm(scene.quality, scene.ct->grid())));
  program.set("slab_mm", slab_mm(scene));
  if (scene.quality.jitter) {
    program.set("second_image_height", static_cast<double>(scene.height));
  }
}

void set_plane(GlProgram& program, const spec::PlaneSurface<double>& plane) {
  program.set("us_size", Eigen::Vector2d(plane.width, plane.height));
  program.set("image_from_local", plane.image_from_local);
  program.set("image_origin", plane.origin);
  program.set("pixel_from_mm", plane.pixel_from_mm);
  program.set("grid_origin_mm", plane.grid_origin_mm);
  program.set("mm_across", plane.mm_across);
  program.set("has_outline", static_cast<int>(plane.has_outline));
  program.set("outline", Eigen::Vector4d(plane.apex_mm.x(), plane.apex_mm.y(), plane.radius_min_mm,
                                         plane.radius_max_mm));
  program.set("outline_half", Eigen::Vector2d(plane.sin_half, plane.cos_half));
  program.set("shows_image", static_cast<int>(plane.shows_image));
  program.set("border_rgb", plane.border_rgb);
  program.set("plane_opacity", plane.opacity);
}

void set_transfer(GlProgram& program, const GlFeatures& features, const TransferTable& table) {
  program.set("transfer", kTransfer);
  program.set("transfer_first_hu", table.first_hu());
  program.set("transfer_size", table.size());
  if (features.cutaway || features.emphasis) program.set("importances", kImportances);
  switch (features.classified) {
    case GlFeatures::Classified::kPreIntegrated:
      program.set("points", kIntegrals);
      program.set("quantum", table.quantum());
      break;
    case GlFeatures::Classified::kByGradientToo:
      program.set("transfer_rows", table.rows());
      program.set("rows_per_gradient", 1 / table.gradient_per_row());
      break;
    case GlFeatures::Classified::kAtMiddle:
      break;
  }
}

void set_shading(GlProgram& program, const GlFeatures& features, const Scene& scene) {
  const VoxelGrid& grid = scene.ct->grid();
  const Shading& shading = scene.shading;
  const Eigen::Matrix3d axes_from_local = grid.directions.transpose();
  program.set("axes_from_local", axes_from_local);
  program.set("full_gradient_per_mm", shading.full_gradient_per_mm);
  if (features.classified == GlFeatures::Classified::kPreIntegrated) {
    program.set("shades_per_root", spec::kShadesPerRoot * std::sqrt(scene.quality.step_voxels));
  }
  if (features.emphasis) program.set("emphasis", shading.emphasis);
  if (features.shaded != GlFeatures::Shaded::kGooch) return;
  const auto view = view_of(scene, grid);
  program.set("gooch_light", Eigen::Vector3d(axes_from_local * spec::gooch_light(view)));
  program.set("gooch_shares",
              Eigen::Vector3d(shading.cool_share, shading.warm_share, shading.silhouette));
}

void set_cutaway(GlProgram& program, const GlFeatures& features, const Scene& scene,
                 const spec::CutawayObjects<double>& objects) {
  constexpr double kEndless = 1e30;  // No region is clear. Infinity would be multiplied by zero.
  if (features.cut_field) {
    program.set("cut_field", kCutField);
    program.set("cut_field_height", scene.height);
  } else {
    program.set("cut_objects", kCutObjects);
    program.set("cut_count", static_cast<int>(objects.polygons.size() + objects.balls.size()));
    program.set("cut_cot", Eigen::Vector2d(objects.cot1, objects.cot2));
  }
  program.set("overlay_mm", std::min(objects.overlay_mm, kEndless));
  const auto& tau = scene.cutaway->constant;
  program.set("fade_by",
              tau ? Eigen::Vector3d(0, tau->lower, tau->upper) : Eigen::Vector3d(1, 0, 0));
}

void set_volume_marching(GlProgram& program, const GlFeatures& features, const Scene& scene,
                         const GlTextures& textures) {
  const bool by_gradient = features.classified == GlFeatures::Classified::kByGradientToo;
  const bool shading = features.shaded != GlFeatures::Shaded::kNot;
  set_transfer(program, features, textures.table());
  if (shading || by_gradient) {
    const Eigen::Vector3d per_mm = scene.ct->grid().spacing_mm.cwiseInverse();
    program.set("half_per_spacing", Eigen::Vector3d(0.5 * per_mm));
    if (features.gradient_texture) program.set("gradients", kGradients);
  }
  if (shading) set_shading(program, features, scene);
  if (features.cutaway) set_cutaway(program, features, scene, textures.cut());
  if (features.skipping) {
    set_brick_walk(program, scene.ct->grid(), textures.brick_count(), kBricks, {}, reach_mm(scene));
  }
  // Nothing is visible between two empty parts that touch: 4 voxels, minus rounding.
  constexpr double kLongestCellOverParts = 3.5;
  constexpr int kAllParts = 255;
  if (features.skipping) {
    program.set("all_parts", scene.quality.step_voxels <= kLongestCellOverParts ? 0 : kAllParts);
  }
}

void set_light(GlProgram& program, const Shading& light) {
  program.set("shade_light",
              Eigen::Vector4d(light.ambient, light.diffuse, light.specular, light.shininess));
}

/// Sets the uniforms of solids, and of geometry of others.
void set_shapes(GlProgram& program, const GlFeatures& features, const GlTextures& textures,
                const std::optional<SharedDepth>& depth) {
  if (features.solids) {
    program.set("solids", kSolids);
    program.set("solid_count", textures.solid_count());
  }
  if (features.shared_depth) {
    program.set("vtk_depth", kDepth);
    program.set("depth_rows", depth->rows);
  }
}

}  // namespace

GlFeatures features_of(const Scene& scene, const GlTextures& textures, bool shared_depth,
                       bool manual_filter) {
  GlFeatures features;
  features.projection = scene.projection;
  features.plane = scene.plane && scene.plane->safety.state != SafetyState::kLost;
  features.capsules = has_capsules(scene);
  features.solids = features.capsules || !scene.spheres.empty();
  features.jitter = scene.quality.jitter;
  features.sparse = sparse_rays(scene).has_value();
  features.shared_depth = shared_depth;
  if (manual_filter) {
    features.filter = textures.has_slices() ? GlFilter::kGathers : GlFilter::kFetches;
  }
  features.voxel_pairs = textures.has_voxel_pairs();
  // Leaps over cells longer than a brick would be neither exact nor worthwhile.
  features.skipping = !drawn_by_predicates(scene) && scene.quality.skip_empty_bricks &&
                      scene.quality.step_voxels <= kBrickVoxels;
  if (scene.projection != Projection::kComposite) return features;
  features.cut_field = CutawayField::needed(scene);
  features.cutaway = features.cut_field || !textures.cut().empty();
  features.beside_ct = has_two_volumes(scene);
  if (scene.predicates) return features;
  if (textures.table().rows() > 1) {
    features.classified = GlFeatures::Classified::kByGradientToo;
  } else if (scene.quality.classification == Classification::kPostClassified) {
    features.classified = GlFeatures::Classified::kAtMiddle;
  }
  if (scene.shading.enabled && textures.table().shades(scene.shading.emphasis)) {
    features.shaded = scene.shading.style == ShadingStyle::kPhong ? GlFeatures::Shaded::kPhong
                                                                  : GlFeatures::Shaded::kGooch;
    features.emphasis = scene.shading.emphasis > 0;
  }
  const bool gradients = features.shaded != GlFeatures::Shaded::kNot ||
                         features.classified == GlFeatures::Classified::kByGradientToo;
  features.gradient_texture = gradients && textures.has_gradients();
  return features;
}

double reach_mm(const Scene& scene) {
  if (!has_two_volumes(scene)) return 0;
  const VoxelGrid& ct = scene.ct->grid();
  const VoxelGrid& other = scene.ultrasound->volume->grid();
  return (other.centre().mm - ct.centre().mm).norm() + ct.extent_mm().norm() +
         other.extent_mm().norm();
}

void set_brick_walk(GlProgram& program, const VoxelGrid& grid, const Eigen::Vector3i& brick_count,
                    int unit, const std::string& prefix, double farthest_mm) {
  program.set(prefix + "bricks", unit);
  program.set(prefix + "brick_count", brick_count);
  program.set(prefix + "bricks_per_voxel", 1.0 / kBrickVoxels);
  // Indices are at most about three times the volume's diagonal away from zero.
  const double farthest = (3 * grid.extent_mm().norm() + farthest_mm) / grid.spacing_mm.minCoeff();
  constexpr double kRounding = 1e-6;  // A few units of single precision.
  program.set(prefix + "brick_margin", 1e-3 + kRounding * farthest);
}

void set_rays(GlProgram& program, const Scene& scene) {
  set_camera(program, scene);
  const VoxelGrid& grid = scene.ct->grid();
  set_volume(program, grid, kCt);
  program.set("ct_strides", Eigen::Vector2i(grid.size[1] > 1 ? grid.size[0] : 0,
                                            grid.size[2] > 1 ? grid.size[0] * grid.size[1] : 0));
}

double opaque_at(const Scene& scene) {
  constexpr double kNeverReached = 2;
  return scene.quality.opaque_at < 1 ? scene.quality.opaque_at : kNeverReached;
}

void set_uniforms(GlProgram& program, const GlFeatures& features, const Scene& scene,
                  const GlTextures& textures, const std::optional<SharedDepth>& depth) {
  const VoxelGrid& grid = scene.ct->grid();
  set_rays(program, scene);
  const bool transfer = !features.predicates || features.beside_ct;
  if (transfer) program.set("opaque_at", opaque_at(scene));
  if (features.shaded == GlFeatures::Shaded::kPhong || features.solids) {
    set_light(program, scene.shading);
  }
  if (features.beside_ct) set_two_volumes(program, scene);
  if (!transfer) {
    if (features.cutaway) set_cutaway(program, features, scene, textures.cut());
  } else if (features.projection == Projection::kComposite) {
    set_volume_marching(program, features, scene, textures);
  } else {
    program.set("grey_level_hu", scene.grey.level_hu);
    program.set("grey_width_hu", scene.grey.width_hu);
    if (features.skipping) {
      set_brick_walk(program, grid, textures.brick_count(), kBricks);
    }
  }
  if (features.plane) set_plane(program, *spec::make_plane<double>(*scene.plane, grid));
  set_shapes(program, features, textures, depth);
}

GlFeatures means_features(const GlFeatures& features) {
  GlFeatures means;
  means.means = means.sparse = true;
  means.plane = features.plane;
  means.solids = features.solids;
  means.capsules = features.capsules;
  means.shared_depth = features.shared_depth;
  means.filter = features.filter;
  means.voxel_pairs = features.voxel_pairs;
  return means;
}

void set_means_uniforms(GlProgram& program, const GlFeatures& features, const Scene& scene,
                        const GlTextures& textures, const std::optional<SharedDepth>& depth) {
  set_rays(program, scene);
  if (features.solids) set_light(program, scene.shading);
  set_shapes(program, features, textures, depth);
  program.set("coarse_front", kFront);
  program.set("coarse_spent", kSpent);
  program.set("opaque_at", opaque_at(scene));
  program.set("background_rgb", scene.background_rgb);
  if (!features.plane) return;
  set_plane(program, *spec::make_plane<double>(*scene.plane, scene.ct->grid()));
  program.set("coarse_behind", kBehind);
  program.set("coarse_live_at", kLiveAt);
}

}  // namespace nav::render
