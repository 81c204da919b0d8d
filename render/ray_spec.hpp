// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "nav/ultrasound_frame.hpp"
#include "nav/volume.hpp"
#include "render/scene.hpp"

/// The one specification of a picture. The reference engine runs it in double; the CPU engine
/// prepares its rays and surfaces with it; the GLSL of shaders/ mirrors it line by line.
///
/// Coordinates. "Local mm" are CT axes (LPS, mm) minus grid.origin_mm, subtracted in double before
/// anything else, so that a CT far from the world's origin costs no digits. "Index" is the
/// continuous voxel index: index = (directionsᵀ · local) ∘ 1/spacing.
///
/// Ray. Pixel (x, y), row 0 at the top, is seen along the ray through its centre; t is the distance
/// from the ray's origin in mm, t >= 0. Perspective: origin = eye. Orthographic: origin on the
/// plane through the eye.
///
/// Box. The volume fills the box of its voxel centres, [0, n - 1] per axis. An axis with a single
/// voxel has no thickness there, so it fills half a voxel either side, [-1/2, 1/2], and its value
/// does not change along it.
///
/// Cells. h = quality.step_voxels · min(spacing). Cell k covers t in [k h, (k + 1) h), for every
/// ray and every scene: a global lattice. Its value is the trilinear HU at t = (k + 1/2) h, the
/// index clamped to [0, n - 1] per axis. Its extinction acts over the length of the cell that lies
/// between the events of the ray (entry, surfaces, exit), so faces, planes and needles cut exactly:
///   alpha = -expm1(-tau(hu) · length_mm).
///
/// Colour. rgb(hu), shaded if shading.enabled by shade() with the gradient at the same point.
///
/// Gradient. Central difference one voxel either way along each index axis, positions clamped to
/// [0, n - 1], divided by 2 · spacing_mm, turned by directions: HU per mm along the CT axes.
///
/// Compositing, front to back, premultiplied: C += (1 - A) · alpha · rgb; A += (1 - A) · alpha.
/// Surfaces are samples of their own alpha at their exact t, sorted by t (equal t: plane, needle,
/// spheres in order); the first of alpha 1 ends the ray. A surface is drawn if t > 0, inside the
/// volume or not. Early termination: the ray ends once A >= quality.opaque_at (< 1).
/// The pixel is C + (1 - A) · background, alpha 1.
namespace nav::render::spec {

template <class S>
using Vec3 = Eigen::Matrix<S, 3, 1>;
template <class S>
using Vec2 = Eigen::Matrix<S, 2, 1>;

// ---- Constants that every engine shares -------------------------------------------------------

/// Below this gradient a sample has no reliable normal: shading fades in linearly from 0 to here,
/// HU/mm. Homogeneous tissue stays unshaded instead of showing noise as facets.
inline constexpr double kFullShadingHuPerMm = 10.0;
/// Width of the state border of the ultrasound plane, inside its edge, mm. Always opaque: it says
/// whether the picture may be trusted.
inline constexpr double kBorderMm = 1.0;
inline const Eigen::Vector3d kValidRgb{0.10, 0.85, 0.30};
inline const Eigen::Vector3d kDegradedRgb{1.00, 0.70, 0.00};
inline const Eigen::Vector3d kStaleRgb{0.60, 0.60, 0.60};
/// Opacity of a stale needle.
inline constexpr double kGhostOpacity = 0.4;
/// A plane seen at less than this sine is edge-on and not drawn.
inline constexpr double kEdgeOnSine = 1e-6;

// ---- Rays -------------------------------------------------------------------------------------

/// A ray, local mm; direction of unit length.
template <class S>
struct Ray {
  Vec3<S> origin;
  Vec3<S> direction;
};

/// The camera as a generator of rays, local mm.
template <class S>
struct View {
  Vec3<S> eye;
  Vec3<S> right;  ///< Unit, to the right of the picture.
  Vec3<S> up;     ///< Unit, to the top of the picture.
  Vec3<S> forward;
  S half_height;  ///< Perspective: tan(fov / 2). Orthographic: half the height, mm.
  bool orthographic;
  int width;
  int height;
};

/// Precondition: a validated camera.
template <class S>
View<S> make_view(const Camera& camera, int width, int height, const VoxelGrid& grid) {
  const Eigen::Vector3d forward = (camera.look_at_ct.mm - camera.eye_ct.mm).normalized();
  const Eigen::Vector3d right = forward.cross(camera.up_ct.v).normalized();
  const Eigen::Vector3d up = right.cross(forward);
  const double half = camera.orthographic ? 0.5 * camera.orthographic_height_mm
                                          : std::tan(0.5 * camera.vertical_fov_rad);
  const Eigen::Vector3d eye = camera.eye_ct.mm - grid.origin_mm;
  return {eye.cast<S>(),        right.cast<S>(),     up.cast<S>(), forward.cast<S>(),
          static_cast<S>(half), camera.orthographic, width,        height};
}

/// Ray through the centre of pixel (x, y); square pixels, row 0 at the top.
template <class S>
Ray<S> ray_of(const View<S>& view, int x, int y) {
  const S pixel = S(2) * view.half_height / static_cast<S>(view.height);
  const S a = (static_cast<S>(x) + S(0.5) - S(0.5) * static_cast<S>(view.width)) * pixel;
  const S b = (S(0.5) * static_cast<S>(view.height) - static_cast<S>(y) - S(0.5)) * pixel;
  const Vec3<S> offset = a * view.right + b * view.up;
  if (view.orthographic) return {view.eye + offset, view.forward};
  return {view.eye, (view.forward + offset).normalized()};
}

// ---- The volume -------------------------------------------------------------------------------

/// Sampling distance, mm.
inline double step_mm(const Quality& quality, const VoxelGrid& grid) {
  return quality.step_voxels * grid.spacing_mm.minCoeff();
}

/// index(t) = origin + t · direction.
template <class S>
Ray<S> index_ray(const Ray<S>& ray, const VoxelGrid& grid) {
  const Eigen::Matrix<S, 3, 3> turn = grid.directions.transpose().cast<S>();
  const Vec3<S> spacing = grid.spacing_mm.cast<S>();
  return {(turn * ray.origin).cwiseQuotient(spacing),
          (turn * ray.direction).cwiseQuotient(spacing)};
}

/// Part of a ray, mm; empty when end <= begin.
template <class S>
struct Interval {
  S begin;
  S end;
};

/// Part of an index ray with t >= 0 inside the volume's box.
template <class S>
Interval<S> clip_to_box(const Ray<S>& index, const std::array<int, 3>& size) {
  Interval<S> in{S(0), std::numeric_limits<S>::max()};
  for (int axis = 0; axis < 3; ++axis) {
    const int n = size[static_cast<std::size_t>(axis)];
    const S low = n > 1 ? S(0) : S(-0.5);
    const S high = n > 1 ? static_cast<S>(n - 1) : S(0.5);
    const S o = index.origin[axis];
    const S d = index.direction[axis];
    if (d == S(0)) {
      if (o < low || o > high) return {S(0), S(0)};
      continue;
    }
    const S a = (low - o) / d;
    const S b = (high - o) / d;
    in.begin = std::max(in.begin, std::min(a, b));
    in.end = std::min(in.end, std::max(a, b));
  }
  return in.end > in.begin ? in : Interval<S>{S(0), S(0)};
}

/// Blinn–Phong with a headlight: light, eye and half vector coincide, so one cosine |n · d| (two-
/// sided) decides. weight in [0, 1] blends from the plain colour (0) to the shaded one (1).
template <class S>
Vec3<S> shade(const Vec3<S>& rgb, S cosine, S weight, const Shading& shading) {
  const S c = std::clamp(std::abs(cosine), S(0), S(1));
  const S lit = static_cast<S>(shading.ambient) + static_cast<S>(shading.diffuse) * c;
  const S gloss = static_cast<S>(shading.specular) * std::pow(c, static_cast<S>(shading.shininess));
  const Vec3<S> full = (rgb * lit + Vec3<S>::Constant(gloss)).cwiseMax(S(0)).cwiseMin(S(1));
  return rgb + weight * (full - rgb);
}

/// shade() of a volume sample: normal = gradient / |gradient|, weight = |gradient| / 10 HU/mm up
/// to 1; a zero gradient leaves the colour as it is. gradient: HU/mm, CT axes.
template <class S>
Vec3<S> shade_sample(const Vec3<S>& rgb, const Vec3<S>& gradient, const Vec3<S>& direction,
                     const Shading& shading) {
  const S norm = gradient.norm();
  if (!(norm > S(0))) return rgb;
  const S weight = std::min(S(1), norm / static_cast<S>(kFullShadingHuPerMm));
  return shade(rgb, gradient.dot(direction) / norm, weight, shading);
}

// ---- Surfaces ---------------------------------------------------------------------------------

/// A surface on a ray.
template <class S>
struct Hit {
  S t;  ///< mm, > 0.
  Vec3<S> rgb;
  S alpha;
};

/// The ultrasound plane, ready to meet rays. z = 0 of the image frame; the picture fills the
/// rectangle (a parallelogram when the calibration shears) of its pixel centres plus half a pixel.
template <class S>
struct PlaneSurface {
  Eigen::Matrix<S, 3, 3> image_from_local;  ///< Rotation; p_image = R · (p_local - origin).
  Vec3<S> origin;                           ///< Of the image frame, local mm.
  Eigen::Matrix<S, 2, 2> pixel_from_mm;
  Vec2<S> grid_origin_mm;  ///< Of pixel (0, 0).
  Vec2<S> mm_across;       ///< Distance of the lines column = c, c + 1; of row = r, r + 1; mm.
  int width;
  int height;
  const std::uint8_t* pixels;
  bool has_outline;
  Vec2<S> apex_mm;
  S radius_min_mm;
  S radius_max_mm;
  S sin_half;
  S cos_half;
  bool shows_picture;  ///< Valid and degraded.
  Vec3<S> border_rgb;
  S opacity;
};

/// Absent when the plane is lost. The frame must outlive the result.
template <class S>
std::optional<PlaneSurface<S>> make_plane(const UltrasoundPlane& plane, const VoxelGrid& grid) {
  const SafetyState state = plane.safety.state;
  if (state == SafetyState::kLost) return {};
  const UltrasoundFrame& frame = plane.frame;
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
      rotation.cast<S>(),
      origin.cast<S>(),
      inverse.cast<S>(),
      frame.grid.origin_mm.cast<S>(),
      {static_cast<S>(area / m.col(1).norm()), static_cast<S>(area / m.col(0).norm())},
      frame.pixels.width(),
      frame.pixels.height(),
      frame.pixels.pixels().data(),
      frame.outline.has_value(),
      outline.apex_mm.cast<S>(),
      static_cast<S>(outline.radius_min_mm),
      static_cast<S>(outline.radius_max_mm),
      static_cast<S>(std::sin(outline.half_angle_rad)),
      static_cast<S>(std::cos(outline.half_angle_rad)),
      state != SafetyState::kStale,
      border.cast<S>(),
      static_cast<S>(plane.opacity)};
}

/// Grey of the picture, [0, 1]: bilinear between pixel centres, clamped to the outermost centres.
template <class S>
S picture_at(const PlaneSurface<S>& plane, S column, S row) {
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

/// Distance of an image point to the nearest edge of what is drawn, mm; negative outside. pixel:
/// the same point as (column, row).
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

/// The plane's sample on a ray: its border, its picture, or nothing.
template <class S>
std::optional<Hit<S>> hit_plane(const PlaneSurface<S>& plane, const Ray<S>& ray) {
  const Vec3<S> o = plane.image_from_local * (ray.origin - plane.origin);
  const Vec3<S> d = plane.image_from_local * ray.direction;
  if (std::abs(d.z()) < static_cast<S>(kEdgeOnSine)) return {};
  const S t = -o.z() / d.z();
  if (!(t > S(0))) return {};
  const Vec2<S> p = (o + t * d).template head<2>();
  const Vec2<S> pixel = plane.pixel_from_mm * (p - plane.grid_origin_mm);
  const S inside = depth_inside(plane, p, pixel);
  if (!(inside >= S(0))) return {};
  if (inside < static_cast<S>(kBorderMm)) return Hit<S>{t, plane.border_rgb, S(1)};
  if (!plane.shows_picture) return {};
  return Hit<S>{t, Vec3<S>::Constant(picture_at(plane, pixel.x(), pixel.y())), plane.opacity};
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

/// The needle's capsule ends exactly at the tip: its axis starts one radius behind it. Absent when
/// lost, ghosted when stale.
template <class S>
std::optional<CapsuleSurface<S>> make_needle(const NeedleShape& needle, const VoxelGrid& grid) {
  if (needle.safety.state == SafetyState::kLost) return {};
  const Eigen::Vector3d back = needle.hub_ct.mm - needle.tip_ct.mm;
  const double length = back.norm();
  const Eigen::Vector3d a =
      needle.tip_ct.mm + back * (std::min(needle.radius_mm, length) / length) - grid.origin_mm;
  const Eigen::Vector3d b = needle.hub_ct.mm - grid.origin_mm;
  const double alpha = needle.safety.state == SafetyState::kStale ? kGhostOpacity : 1.0;
  return CapsuleSurface<S>{a.cast<S>(), b.cast<S>(), static_cast<S>(needle.radius_mm),
                           needle.rgb.cast<S>(), static_cast<S>(alpha)};
}

template <class S>
CapsuleSurface<S> make_sphere(const SphereShape& sphere, const VoxelGrid& grid) {
  const Vec3<S> centre = (sphere.centre_ct.mm - grid.origin_mm).template cast<S>();
  return {centre, centre, static_cast<S>(sphere.radius_mm), sphere.rgb.cast<S>(),
          static_cast<S>(sphere.opacity)};
}

/// Where a ray enters a sphere; negative: behind the origin; infinity: never. The discriminant is
/// taken from the distance of the centre to the ray, which does not cancel for a far eye.
template <class S>
S enter_sphere(const Vec3<S>& centre, S radius, const Ray<S>& ray) {
  const Vec3<S> m = centre - ray.origin;
  const S along = m.dot(ray.direction);
  const S square = radius * radius - (m - along * ray.direction).squaredNorm();
  return square < S(0) ? std::numeric_limits<S>::infinity() : along - std::sqrt(square);
}

/// Where a ray enters the capsule, as enter_sphere(): the cylinder's side between the two end
/// points, else the first of the end spheres.
template <class S>
S enter_capsule(const CapsuleSurface<S>& capsule, const Ray<S>& ray) {
  const Vec3<S> axis = capsule.b - capsule.a;
  const S length = axis.norm();
  if (!(length > S(0))) return enter_sphere(capsule.a, capsule.radius, ray);
  const Vec3<S> u = axis / length;
  const Vec3<S> m = ray.origin - capsule.a;
  const Vec3<S> across = ray.direction - ray.direction.dot(u) * u;  // Seen along the axis.
  const Vec3<S> start = m - m.dot(u) * u;
  const S a = across.squaredNorm();
  if (a > S(0)) {
    const S along = -across.dot(start) / a;
    const S square = capsule.radius * capsule.radius - (start + along * across).squaredNorm();
    if (square < S(0))
      return std::numeric_limits<S>::infinity();  // Misses the endless cylinder, so both ends too.
    const S t = along - std::sqrt(square / a);
    const S foot = (m + t * ray.direction).dot(u);
    if (foot >= S(0) && foot <= length) return t;
  }
  return std::min(enter_sphere(capsule.a, capsule.radius, ray),
                  enter_sphere(capsule.b, capsule.radius, ray));
}

/// The front surface, shaded by the headlight; absent when it lies behind the ray's origin (an eye
/// inside sees nothing of it). Solids are always shaded, also where shading.enabled is off.
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
  return Hit<S>{t, shade(capsule.rgb, normal.dot(ray.direction), S(1), shading), capsule.alpha};
}

}  // namespace nav::render::spec
