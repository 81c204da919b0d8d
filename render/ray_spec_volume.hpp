// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "nav/volume.hpp"
#include "render/scene.hpp"

/// Rays, cells, shading and the constants of ray_spec.hpp.
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

}  // namespace nav::render::spec
