// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl_live.hpp"

#include <algorithm>

namespace nav::render {
namespace {

/// Members that decide the layers, one comparison each.
bool same(const Camera& a, const Camera& b) {
  return a.eye_ct.mm == b.eye_ct.mm && a.look_at_ct.mm == b.look_at_ct.mm &&
         a.up_ct.v == b.up_ct.v && a.vertical_fov_rad == b.vertical_fov_rad &&
         a.orthographic == b.orthographic && a.orthographic_height_mm == b.orthographic_height_mm;
}

bool same(const Shading& a, const Shading& b) {
  return a.enabled == b.enabled && a.style == b.style && a.emphasis == b.emphasis &&
         a.full_gradient_per_mm == b.full_gradient_per_mm && a.ambient == b.ambient &&
         a.diffuse == b.diffuse && a.specular == b.specular && a.shininess == b.shininess &&
         a.cool_share == b.cool_share && a.warm_share == b.warm_share &&
         a.silhouette == b.silhouette;
}

bool same(const Quality& a, const Quality& b) {
  return a.step_voxels == b.step_voxels && a.classification == b.classification &&
         a.opaque_at == b.opaque_at && a.skip_empty_bricks == b.skip_empty_bricks &&
         a.adaptive_error == b.adaptive_error && a.jitter == b.jitter;
}

bool same(const SectorOutline& a, const SectorOutline& b) {
  return a.apex_mm == b.apex_mm && a.radius_min_mm == b.radius_min_mm &&
         a.radius_max_mm == b.radius_max_mm && a.half_angle_rad == b.half_angle_rad;
}

bool same(const UltrasoundPlane& a, const UltrasoundPlane& b) {
  const UltrasoundFrame& f = a.frame;
  const UltrasoundFrame& g = b.frame;
  return a.safety.state == b.safety.state && a.opacity == b.opacity &&
         f.pixels.width() == g.pixels.width() && f.pixels.height() == g.pixels.height() &&
         f.grid.mm_per_pixel == g.grid.mm_per_pixel && f.grid.origin_mm == g.grid.origin_mm &&
         f.outline.has_value() == g.outline.has_value() &&
         (!f.outline || same(*f.outline, *g.outline)) &&
         a.ct_from_image.rotation().coeffs() == b.ct_from_image.rotation().coeffs() &&
         a.ct_from_image.translation_mm() == b.ct_from_image.translation_mm();
}

bool same(const NeedleShape& a, const NeedleShape& b) {
  return a.tip_ct.mm == b.tip_ct.mm && a.hub_ct.mm == b.hub_ct.mm && a.radius_mm == b.radius_mm &&
         a.rgb == b.rgb && a.safety.state == b.safety.state;
}

bool same(const SphereShape& a, const SphereShape& b) {
  return a.centre_ct.mm == b.centre_ct.mm && a.radius_mm == b.radius_mm && a.rgb == b.rgb &&
         a.opacity == b.opacity;
}

bool same(const LineShape& a, const LineShape& b) {
  return a.from_ct.mm == b.from_ct.mm && a.to_ct.mm == b.to_ct.mm && a.radius_mm == b.radius_mm &&
         a.rgb == b.rgb && a.opacity == b.opacity;
}

bool same(const BoxObject& a, const BoxObject& b) {
  return a.centre_ct.mm == b.centre_ct.mm && a.half_edges_ct == b.half_edges_ct;
}

bool same(const PolygonObject& a, const PolygonObject& b) {
  return std::equal(a.vertices_ct.begin(), a.vertices_ct.end(), b.vertices_ct.begin(),
                    b.vertices_ct.end(),
                    [](const auto& x, const auto& y) { return x.mm == y.mm; });
}

template <class T>
bool all_same(const std::vector<T>& a, const std::vector<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const T& x, const T& y) { return same(x, y); });
}

bool same(const Cutaway& a, const Cutaway& b) {
  return a.theta1_rad == b.theta1_rad && a.theta2_rad == b.theta2_rad &&
         a.overlay_mm == b.overlay_mm && a.around_plane == b.around_plane &&
         a.around_needle == b.around_needle && a.around_spheres == b.around_spheres &&
         all_same(a.polygons, b.polygons) && all_same(a.boxes, b.boxes) && a.meshes == b.meshes;
}

template <class T>
bool same(const std::optional<T>& a, const std::optional<T>& b) {
  return a.has_value() == b.has_value() && (!a || same(*a, *b));
}

const void* storage(const Scene& scene) {
  return scene.plane ? scene.plane->frame.pixels.pixels().data() : nullptr;
}

}  // namespace

GlChange change_between(const Scene& before, const Scene& now) {
  const bool layers_hold =
      before.ct == now.ct && same_classification(before.transfer, now.transfer) &&
      same(before.shading, now.shading) && same(before.plane, now.plane) &&
      same(before.needle, now.needle) && all_same(before.spheres, now.spheres) &&
      same(before.camera, now.camera) && same(before.quality, now.quality) &&
      before.width == now.width && before.height == now.height &&
      all_same(before.lines, now.lines) && same(before.cutaway, now.cutaway) &&
      before.projection == now.projection && before.grey.level_hu == now.grey.level_hu &&
      before.grey.width_hu == now.grey.width_hu;
  if (!layers_hold) return GlChange::kAll;
  return storage(before) == storage(now) ? GlChange::kNothing : GlChange::kPicture;
}

}  // namespace nav::render
