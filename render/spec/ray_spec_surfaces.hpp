// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "nav/ultrasound_image.hpp"
#include "render/spec/ray_spec_volume.hpp"

/// The surfaces of ray_spec.hpp: ultrasound plane, needle, spheres, lines.
namespace nav::render::spec {

/// A surface on a ray.
template <class S>
struct Hit {
  S t;  ///< mm, > 0.
  Vec3<S> rgb;
  S alpha;
  /// The ray hit the ultrasound image at `pixel`, and rgb is its grey. The colour can be filled in
  /// last because nothing else depends on it.
  bool image = false;
  Vec2<S> pixel = Vec2<S>::Zero();  ///< Column and row in the ultrasound image.
};

/// The ultrasound plane, prepared for intersection with rays: z = 0 of the image frame. The
/// ultrasound image fills the rectangle (a parallelogram when the calibration shears) of its pixel
/// centres plus half a pixel.
template <class S>
struct PlaneSurface {
  Eigen::Matrix<S, 3, 3> image_from_local;  ///< Rotation; p_image = R · (p_local - origin).
  Vec3<S> origin;                           ///< Origin of the image frame, local mm.
  Eigen::Matrix<S, 2, 2> pixel_from_mm;
  Vec2<S> grid_origin_mm;  ///< Position of pixel (0, 0), image mm.
  Vec2<S> mm_across;  ///< Distance between the lines column = c and c + 1, and between the lines
                      ///< row = r and r + 1; mm.
  int width;
  int height;
  const std::uint8_t* pixels;
  bool has_outline;
  Vec2<S> apex_mm;
  S radius_min_mm;
  S radius_max_mm;
  S sin_half;
  S cos_half;
  bool shows_image;  ///< True for the states valid and degraded.
  Vec3<S> border_rgb;
  S opacity;
};

/// No value when the plane is lost. The frame must outlive the result.
template <class S>
std::optional<PlaneSurface<S>> make_plane(const UltrasoundPlane& plane, const VoxelGrid& grid) {
  const SafetyState state = plane.safety.state;
  if (state == SafetyState::kLost) return {};
  const UltrasoundImage& frame = plane.frame;
  const Eigen::Matrix2d& m = frame.grid.mm_per_pixel;
  const double area = std::abs(m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0));
  Eigen::Matrix2d inverse;
  inverse << m(1, 1), -m(0, 1), -m(1, 0), m(0, 0);
  inverse /= m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
  const SectorOutline outline =
      frame.outline.value_or(SectorOutline{Eigen::Vector2d::Zero(), 0, 0, 0});
  const Eigen::Matrix3d rotation = plane.ct_from_image.rotation().toRotationMatrix().transpose();
  const Eigen::Vector3d origin = plane.ct_from_image.translation_mm() - grid.origin_mm;
  const Eigen::Vector3d border = state == SafetyState::kValid      ? kValidRgb
                                 : state == SafetyState::kDegraded ? kDegradedRgb
                                                                   : kStaleRgb;
  return PlaneSurface<S>{
      .image_from_local = rotation.cast<S>(),
      .origin = origin.cast<S>(),
      .pixel_from_mm = inverse.cast<S>(),
      .grid_origin_mm = frame.grid.origin_mm.cast<S>(),
      .mm_across = {static_cast<S>(area / m.col(1).norm()), static_cast<S>(area / m.col(0).norm())},
      .width = frame.pixels.width(),
      .height = frame.pixels.height(),
      .pixels = frame.pixels.pixels().data(),
      .has_outline = frame.outline.has_value(),
      .apex_mm = outline.apex_mm.cast<S>(),
      .radius_min_mm = static_cast<S>(outline.radius_min_mm),
      .radius_max_mm = static_cast<S>(outline.radius_max_mm),
      .sin_half = static_cast<S>(std::sin(outline.half_angle_rad)),
      .cos_half = static_cast<S>(std::cos(outline.half_angle_rad)),
      .shows_image = state != SafetyState::kStale,
      .border_rgb = border.cast<S>(),
      .opacity = static_cast<S>(plane.opacity)};
}

/// Grey of the ultrasound image, [0, 1]: bilinear between pixel centres, clamped to the outermost
/// centres.
template <class S>
S image_at(const PlaneSurface<S>& plane, S column, S row) {
  const S c = std::clamp(column, S(0), static_cast<S>(plane.width - 1));
  const S r = std::clamp(row, S(0), static_cast<S>(plane.height - 1));
  const int c0 = std::min(static_cast<int>(c), std::max(plane.width - 2, 0));
  const int r0 = std::min(static_cast<int>(r), std::max(plane.height - 2, 0));
  const int c1 = std::min(c0 + 1, plane.width - 1);
  const int r1 = std::min(r0 + 1, plane.height - 1);
  const auto at = [&](int i, int j) {
    return static_cast<S>(plane.pixels[static_cast<std::ptrdiff_t>(j) * plane.width + i]);
  };
  const S u = c - static_cast<S>(c0);
  const S v = r - static_cast<S>(r0);
  const S top = at(c0, r0) + u * (at(c1, r0) - at(c0, r0));
  const S bottom = at(c0, r1) + u * (at(c1, r1) - at(c0, r1));
  return (top + v * (bottom - top)) / S(255);
}

/// Distance of an image point to the nearest edge of the drawn area, mm; negative outside. \p pixel
/// is the same point as (column, row).
template <class S>
S depth_inside(const PlaneSurface<S>& plane, const Vec2<S>& p_image, const Vec2<S>& pixel) {
  const S half = S(0.5);
  S inside = std::min(std::min(pixel.x() + half, static_cast<S>(plane.width) - half - pixel.x()) *
                          plane.mm_across.x(),
                      std::min(pixel.y() + half, static_cast<S>(plane.height) - half - pixel.y()) *
                          plane.mm_across.y());
  if (!plane.has_outline) return inside;
  const Vec2<S> d = p_image - plane.apex_mm;
  const S radius = d.norm();
  inside = std::min(inside, std::min(radius - plane.radius_min_mm, plane.radius_max_mm - radius));
  return std::min(inside, d.y() * plane.sin_half - std::abs(d.x()) * plane.cos_half);
}

/// Intersections of neighbouring rays with the plane. One ray meets the plane at p. The ray a
/// pixels to the right and b pixels up meets it at p + (a · right + b · up) / w with
/// w = 1 + (a, b) · turn. If w <= 0, that intersection lies behind the eye.
template <class S>
struct PlanePixel {
  Vec2<S> right;  ///< Image mm.
  Vec2<S> up;
  Vec2<S> turn;  ///< 0 for parallel rays.
};

/// PlanePixel of the ray that meets the plane at t. \p along: the direction of the ray in the image
/// frame.
template <class S>
PlanePixel<S> pixel_on_plane(const PlaneSurface<S>& plane, const View<S>& view, const Ray<S>& ray,
                             const Vec3<S>& along, S t) {
  const S pixel = S(2) * view.half_height / static_cast<S>(view.height);
  const S apart = view.orthographic ? pixel : pixel * t * ray.direction.dot(view.forward);
  const Vec3<S> right = apart * (plane.image_from_local * view.right);
  const Vec3<S> up = apart * (plane.image_from_local * view.up);
  // Decrease of t per pixel, mm.
  const Vec2<S> sooner = Vec2<S>(right.z(), up.z()) / along.z();
  return {right.template head<2>() - sooner.x() * along.template head<2>(),
          up.template head<2>() - sooner.y() * along.template head<2>(),
          view.orthographic ? Vec2<S>(Vec2<S>::Zero()) : Vec2<S>(sooner / t)};
}

/// True when a point at the distance inside >= 0 from the edge is on the border. It is on the
/// border when it is nearer to the edge than kBorderMm, or when one of eight points at
/// kBorderPixels around it in the rendered image lies outside.
template <class S>
bool on_border(const PlaneSurface<S>& plane, const Vec2<S>& p_image, S inside,
               const PlanePixel<S>& step) {
  if (inside < static_cast<S>(kBorderMm)) return true;
  constexpr auto kReach = static_cast<S>(kBorderPixels);
  const S farthest = kReach * std::sqrt(step.right.squaredNorm() + step.up.squaredNorm());
  if (inside * (S(1) - kReach * step.turn.norm()) > farthest) return false;
  for (int k = 0; k < 9; ++k) {
    const Vec2<S> way(static_cast<S>(k % 3 - 1), static_cast<S>(k / 3 - 1));
    const Vec2<S> to = way * (k % 2 == 0 ? kReach * static_cast<S>(M_SQRT1_2) : kReach);
    const S w = S(1) + to.dot(step.turn);
    if (!(w > S(0))) return true;
    const Vec2<S> q = p_image + (to.x() * step.right + to.y() * step.up) / w;
    const Vec2<S> pixel = plane.pixel_from_mm * (q - plane.grid_origin_mm);
    if (!(depth_inside(plane, q, pixel) >= S(0))) return true;
  }
  return false;
}

/// The plane's sample on a ray of a view: its border, its image without the grey value, or no
/// value.
template <class S>
std::optional<Hit<S>> reach_plane(const PlaneSurface<S>& plane, const View<S>& view,
                                  const Ray<S>& ray) {
  const Vec3<S> o = plane.image_from_local * (ray.origin - plane.origin);
  const Vec3<S> d = plane.image_from_local * ray.direction;
  if (std::abs(d.z()) < static_cast<S>(kEdgeOnSine)) return {};
  const S t = -o.z() / d.z();
  if (!(t > S(0))) return {};
  const Vec2<S> p = (o + t * d).template head<2>();
  const Vec2<S> pixel = plane.pixel_from_mm * (p - plane.grid_origin_mm);
  const S inside = depth_inside(plane, p, pixel);
  if (!(inside >= S(0))) return {};
  if (on_border(plane, p, inside, pixel_on_plane(plane, view, ray, d, t))) {
    return Hit<S>{t, plane.border_rgb, S(1)};
  }
  if (!plane.shows_image) return {};
  return Hit<S>{
      .t = t, .rgb = Vec3<S>::Zero(), .alpha = plane.opacity, .image = true, .pixel = pixel};
}

/// Does the same as reach_plane() and reads the grey of the ultrasound image.
template <class S>
std::optional<Hit<S>> hit_plane(const PlaneSurface<S>& plane, const View<S>& view,
                                const Ray<S>& ray) {
  auto hit = reach_plane(plane, view, ray);
  if (hit && hit->image) {
    hit->rgb.setConstant(image_at(plane, hit->pixel.x(), hit->pixel.y()));
  }
  return hit;
}

/// A capsule or, with a = b, a sphere; local mm.
template <class S>
struct CapsuleSurface {
  Vec3<S> a;
  Vec3<S> b;
  S radius;
  Vec3<S> rgb;
  S alpha;
};

/// Makes the needle's capsule, which ends exactly at the tip: its axis starts one radius behind the
/// tip. No value when the needle is lost; translucent when it is stale.
template <class S>
std::optional<CapsuleSurface<S>> make_needle(const NeedleShape& needle, const VoxelGrid& grid) {
  if (needle.safety.state == SafetyState::kLost) return {};
  const Eigen::Vector3d back = needle.hub_ct.mm - needle.tip_ct.mm;
  const double length = back.norm();
  const Eigen::Vector3d a =
      needle.tip_ct.mm + back * (std::min(needle.radius_mm, length) / length) - grid.origin_mm;
  const Eigen::Vector3d b = needle.hub_ct.mm - grid.origin_mm;
  const double alpha = needle.safety.state == SafetyState::kStale ? kGhostOpacity : 1.0;
  return CapsuleSurface<S>{.a = a.cast<S>(),
                           .b = b.cast<S>(),
                           .radius = static_cast<S>(needle.radius_mm),
                           .rgb = needle.rgb.cast<S>(),
                           .alpha = static_cast<S>(alpha)};
}

template <class S>
CapsuleSurface<S> make_line(const LineShape& line, const VoxelGrid& grid) {
  const Eigen::Vector3d a = line.from_ct.mm - grid.origin_mm;
  const Eigen::Vector3d b = line.to_ct.mm - grid.origin_mm;
  return {.a = a.cast<S>(),
          .b = b.cast<S>(),
          .radius = static_cast<S>(line.radius_mm),
          .rgb = line.rgb.cast<S>(),
          .alpha = static_cast<S>(line.opacity)};
}

template <class S>
CapsuleSurface<S> make_sphere(const SphereShape& sphere, const VoxelGrid& grid) {
  const Vec3<S> centre = (sphere.centre_ct.mm - grid.origin_mm).template cast<S>();
  return {.a = centre,
          .b = centre,
          .radius = static_cast<S>(sphere.radius_mm),
          .rgb = sphere.rgb.cast<S>(),
          .alpha = static_cast<S>(sphere.opacity)};
}

/// Distance at which a ray enters a sphere, mm; negative: behind the origin; infinity: no
/// intersection. The discriminant comes from the distance of the centre to the ray, which does not
/// cancel for a distant eye.
template <class S>
S enter_sphere(const Vec3<S>& centre, S radius, const Ray<S>& ray) {
  const Vec3<S> m = centre - ray.origin;
  const S along = m.dot(ray.direction);
  const S square = radius * radius - (m - along * ray.direction).squaredNorm();
  return square < S(0) ? std::numeric_limits<S>::infinity() : along - std::sqrt(square);
}

/// Distance at which a ray enters the capsule; see enter_sphere(). It enters the side of the
/// cylinder between the two end points, or otherwise the nearer of the end spheres.
template <class S>
S enter_capsule(const CapsuleSurface<S>& capsule, const Ray<S>& ray) {
  const Vec3<S> axis = capsule.b - capsule.a;
  const S length = axis.norm();
  if (!(length > S(0))) return enter_sphere(capsule.a, capsule.radius, ray);
  const Vec3<S> u = axis / length;
  const Vec3<S> m = ray.origin - capsule.a;
  const Vec3<S> across = ray.direction - ray.direction.dot(u) * u;  // Projection across the axis.
  const Vec3<S> start = m - m.dot(u) * u;
  const S a = across.squaredNorm();
  if (a > S(0)) {
    const S along = -across.dot(start) / a;
    const S square = capsule.radius * capsule.radius - (start + along * across).squaredNorm();
    if (square < S(0))
      return std::numeric_limits<S>::infinity();  // Misses the infinite cylinder and both ends.
    const S t = along - std::sqrt(square / a);
    const S foot = (m + t * ray.direction).dot(u);
    if (foot >= S(0) && foot <= length) return t;
  }
  return std::min(enter_sphere(capsule.a, capsule.radius, ray),
                  enter_sphere(capsule.b, capsule.radius, ray));
}

/// The front surface, shaded by Blinn–Phong with the headlight. No value when it lies behind the
/// ray's origin (an eye inside a solid does not see it). Solids are always shaded, also when
/// shading.enabled is false.
template <class S>
std::optional<Hit<S>> hit_capsule(const CapsuleSurface<S>& capsule, const Ray<S>& ray,
                                  const Shading& shading) {
  const S t = enter_capsule(capsule, ray);
  if (!(t > S(0) && std::isfinite(t))) return {};
  const Vec3<S> p = ray.origin + t * ray.direction;
  const Vec3<S> axis = capsule.b - capsule.a;
  const S square = axis.squaredNorm();
  const S foot = square > S(0) ? std::clamp((p - capsule.a).dot(axis) / square, S(0), S(1)) : S(0);
  const Vec3<S> normal = (p - capsule.a - foot * axis) / capsule.radius;
  return Hit<S>{t, phong(capsule.rgb, normal.dot(ray.direction), shading), capsule.alpha};
}

}  // namespace nav::render::spec
