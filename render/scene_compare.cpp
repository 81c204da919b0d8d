// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/scene_compare.hpp"

#include <algorithm>
#include <tuple>

#include "render/two_volumes.hpp"

namespace nav::render {
namespace {

/// Calls same() on the values of two optionals. An absent one equals only an absent one.
template <class T, class Same>
bool same_optional(const std::optional<T>& a, const std::optional<T>& b, const Same& same) {
  if (!a || !b) return a.has_value() == b.has_value();
  return same(*a, *b);
}

template <class T, class Same>
bool same_list(const std::vector<T>& a, const std::vector<T>& b, const Same& same) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

bool same_camera(const Camera& a, const Camera& b) {
  const auto all = [](const Camera& c) {
    return std::tie(c.eye_ct.mm, c.look_at_ct.mm, c.up_ct.v, c.vertical_fov_rad, c.orthographic,
                    c.orthographic_height_mm);
  };
  return all(a) == all(b);
}

bool same_shading(const Shading& a, const Shading& b) {
  const auto all = [](const Shading& s) {
    return std::tie(s.enabled, s.style, s.emphasis, s.full_gradient_per_mm, s.ambient, s.diffuse,
                    s.specular, s.shininess, s.cool_share, s.warm_share, s.silhouette);
  };
  return all(a) == all(b);
}

/// Compares all but `provisional`: provisional images are not kept as images of their scene.
bool same_quality(const Quality& a, const Quality& b) {
  const auto all = [](const Quality& q) {
    return std::tie(q.step_voxels, q.classification, q.opaque_at, q.skip_empty_bricks, q.jitter,
                    q.pixel_error);
  };
  return all(a) == all(b);
}

bool same_outline(const SectorOutline& a, const SectorOutline& b) {
  const auto all = [](const SectorOutline& o) {
    return std::tie(o.apex_mm, o.radius_min_mm, o.radius_max_mm, o.half_angle_rad);
  };
  return all(a) == all(b);
}

/// Compares everything but the pixels: where the ultrasound image lies and how it is drawn.
bool same_place(const UltrasoundPlane& a, const UltrasoundPlane& b) {
  return a.frame.pixels.width() == b.frame.pixels.width() &&
         a.frame.pixels.height() == b.frame.pixels.height() &&
         a.frame.grid.mm_per_pixel == b.frame.grid.mm_per_pixel &&
         a.frame.grid.origin_mm == b.frame.grid.origin_mm &&
         same_optional(a.frame.outline, b.frame.outline, same_outline) &&
         a.ct_from_image.rotation().coeffs() == b.ct_from_image.rotation().coeffs() &&
         a.ct_from_image.translation_mm() == b.ct_from_image.translation_mm() &&
         a.opacity == b.opacity && a.safety.state == b.safety.state;
}

bool same_pixels(const UltrasoundPlane& a, const UltrasoundPlane& b) {
  const auto x = a.frame.pixels.pixels();
  const auto y = b.frame.pixels.pixels();
  return (x.data() == y.data() && x.size() == y.size()) ||
         std::equal(x.begin(), x.end(), y.begin(), y.end());
}

bool same_needle(const NeedleShape& a, const NeedleShape& b) {
  const auto all = [](const NeedleShape& n) {
    return std::tie(n.tip_ct.mm, n.hub_ct.mm, n.radius_mm, n.rgb, n.safety.state);
  };
  return all(a) == all(b);
}

bool same_sphere(const SphereShape& a, const SphereShape& b) {
  const auto all = [](const SphereShape& s) {
    return std::tie(s.centre_ct.mm, s.radius_mm, s.rgb, s.opacity);
  };
  return all(a) == all(b);
}

bool same_line(const LineShape& a, const LineShape& b) {
  const auto all = [](const LineShape& l) {
    return std::tie(l.from_ct.mm, l.to_ct.mm, l.radius_mm, l.rgb, l.opacity);
  };
  return all(a) == all(b);
}

bool same_point(const Point<frames::Ct>& a, const Point<frames::Ct>& b) { return a.mm == b.mm; }

bool same_polygon(const PolygonObject& a, const PolygonObject& b) {
  return same_list(a.vertices_ct, b.vertices_ct, same_point);
}

bool same_box(const BoxObject& a, const BoxObject& b) {
  return a.centre_ct.mm == b.centre_ct.mm && a.half_edges_ct == b.half_edges_ct;
}

bool same_cutaway(const Cutaway& a, const Cutaway& b) {
  const auto plain = [](const Cutaway& c) {
    return std::tie(c.theta1_rad, c.theta2_rad, c.overlay_mm, c.around_plane, c.around_needle,
                    c.around_spheres, c.meshes);
  };
  const auto same_thresholds = [](const Cutaway::Thresholds& x, const Cutaway::Thresholds& y) {
    return x.lower == y.lower && x.upper == y.upper;
  };
  return plain(a) == plain(b) && same_optional(a.constant, b.constant, same_thresholds) &&
         same_list(a.polygons, b.polygons, same_polygon) && same_list(a.boxes, b.boxes, same_box);
}

bool same_ultrasound(const UltrasoundVolume& a, const UltrasoundVolume& b) {
  return a.volume == b.volume && a.ct_importance == b.ct_importance &&
         same_drawing(a.predicates, b.predicates);
}

bool same_view(const Scene& a, const Scene& b) {
  return a.ct == b.ct && a.gradient_source == b.gradient_source && a.width == b.width &&
         a.height == b.height && a.background_rgb == b.background_rgb &&
         a.projection == b.projection && a.grey.level_hu == b.grey.level_hu &&
         a.grey.width_hu == b.grey.width_hu && same_camera(a.camera, b.camera) &&
         same_shading(a.shading, b.shading) && same_quality(a.quality, b.quality) &&
         same_classification(a.transfer, b.transfer) &&
         same_optional(a.predicates, b.predicates, same_drawing) &&
         same_optional(a.ultrasound, b.ultrasound, same_ultrasound);
}

bool same_geometry(const Scene& a, const Scene& b) {
  return same_optional(a.plane, b.plane, same_place) &&
         same_optional(a.needle, b.needle, same_needle) &&
         same_list(a.spheres, b.spheres, same_sphere) && same_list(a.lines, b.lines, same_line) &&
         same_optional(a.cutaway, b.cutaway, same_cutaway);
}

/// The model of the volume or of the second volume; null if the scene is drawn without predicates.
const PredicateModel* model_of(const Scene& scene) {
  if (drawn_by_predicates(scene)) return &scene.predicates->model;
  return has_two_volumes(scene) ? &scene.ultrasound->predicates.model : nullptr;
}

}  // namespace

SceneChange change_between(const Scene& before, const Scene& after) {
  if (!same_view(before, after)) return SceneChange::kView;
  if (!same_geometry(before, after)) return SceneChange::kGeometry;
  return same_optional(before.plane, after.plane, same_pixels) ? SceneChange::kNothing
                                                               : SceneChange::kPixels;
}

bool asks_same_predicates(const Scene& before, const Scene& after) {
  const PredicateModel* a = model_of(before);
  const PredicateModel* b = model_of(after);
  if (b == nullptr) return true;
  return a != nullptr && drawn_by_predicates(before) == drawn_by_predicates(after) &&
         same_set(*a, *b);
}

}  // namespace nav::render
