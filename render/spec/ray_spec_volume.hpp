// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error \
    "expected a compiler that knows infinities and NaN (-fno-finite-math-only), found finite math only"
#endif

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "nav/volume.hpp"
#include "render/scene.hpp"

/// Rays, cells, shading and constants of ray_spec.hpp.
namespace nav::render::spec {

template <class S>
using Vec3 = Eigen::Matrix<S, 3, 1>;
template <class S>
using Vec2 = Eigen::Matrix<S, 2, 1>;

// ---- Constants that every engine shares -------------------------------------------------------

/// Width of the state border of the ultrasound plane, inside its edge, mm. The border is always
/// opaque because it says whether the ultrasound image can be trusted.
inline constexpr double kBorderMm = 1.0;
/// Least width of the border in pixels of the rendered image, at any distance and angle, so that
/// the line has no gaps. It is no multiple of 1/2, because edges in line with pixels would meet
/// such a multiple exactly.
inline constexpr double kBorderPixels = 1.7;
inline const Eigen::Vector3d kValidRgb{0.10, 0.85, 0.30};
inline const Eigen::Vector3d kDegradedRgb{1.00, 0.70, 0.00};
inline const Eigen::Vector3d kStaleRgb{0.60, 0.60, 0.60};
/// Opacity of a stale needle.
inline constexpr double kGhostOpacity = 0.4;
/// Least sine of the angle of view: a plane seen at less than this is edge-on and not drawn.
inline constexpr double kEdgeOnSine = 1e-6;

/// Bow of a cell: the mean over the cell of the parabola through three lattice values, minus the
/// mean of the line from v0 to v1. \p before: the value at the lattice point in front of v0.
inline double bow_of(double before, double v0, double v1) { return (2 * v0 - before - v1) / 12; }
/// Limit of the bow: the mean follows it by at most this share of the change from v0 to v1.
inline constexpr double kMaxBowShare = 0.5;

// ---- Rays -------------------------------------------------------------------------------------

/// A ray, local mm. The direction has unit length.
template <class S>
struct Ray {
  Vec3<S> origin;
  Vec3<S> direction;
};

/// The camera's parameters for generating rays, local mm.
template <class S>
struct View {
  Vec3<S> eye;
  Vec3<S> right;  ///< Unit length, to the right in the rendered image.
  Vec3<S> up;     ///< Unit length, to the top of the rendered image.
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
  return {.eye = eye.cast<S>(),
          .right = right.cast<S>(),
          .up = up.cast<S>(),
          .forward = forward.cast<S>(),
          .half_height = static_cast<S>(half),
          .orthographic = camera.orthographic,
          .width = width,
          .height = height};
}

/// The ray through the centre of pixel (x, y); pixels are square, row 0 is at the top.
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

/// Step between samples, mm.
inline double step_mm(const Quality& quality, const VoxelGrid& grid) {
  return quality.step_voxels * grid.spacing_mm.minCoeff();
}

/// The ray in index coordinates: index(t) = origin + t · direction.
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

/// The part of an index ray with t >= 0 inside the volume's box, mm.
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

/// Trilinear HU at an index, clamped to the box of voxel centres.
inline double value_at(const StoredVolume& ct, const Eigen::Vector3d& index) {
  const auto& size = ct.grid().size;
  const std::span<const std::int16_t> hu = ct.values();
  std::array<std::size_t, 3> low{};
  std::array<std::size_t, 3> high{};
  Eigen::Vector3d w;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double x = std::clamp(index[axis], 0.0, static_cast<double>(size[a] - 1));
    const int i = std::min(static_cast<int>(x), std::max(size[a] - 2, 0));
    low[a] = static_cast<std::size_t>(i);
    high[a] = static_cast<std::size_t>(std::min(i + 1, size[a] - 1));
    w[axis] = x - i;
  }
  const auto row = [&](std::size_t j, std::size_t k) {
    const std::size_t start =
        (k * static_cast<std::size_t>(size[1]) + j) * static_cast<std::size_t>(size[0]);
    const double a = hu[start + low[0]];
    return a + w.x() * (hu[start + high[0]] - a);
  };
  const auto slice = [&](std::size_t k) {
    const double a = row(low[1], k);
    return a + w.y() * (row(high[1], k) - a);
  };
  const double a = slice(low[2]);
  return a + w.z() * (slice(high[2]) - a);
}

/// Share of a cell, [0, 1), by which the cells of a pixel's ray are shifted when quality.jitter is
/// on. It is an integer hash, which is the same on every device.
inline double jitter_of(int x, int y) {
  auto h =
      static_cast<std::uint32_t>(x) * 0x8da6b343U + static_cast<std::uint32_t>(y) * 0xd8163841U;
  h = (h ^ (h >> 16)) * 0x7feb352dU;
  h = (h ^ (h >> 15)) * 0x846ca68bU;
  return static_cast<double>((h ^ (h >> 16)) >> 8) / 16777216.0;
}

/// Blinn–Phong shading with a headlight. Light, eye and half vector coincide, so the result depends
/// only on the cosine |n · d| (two-sided).
template <class S>
Vec3<S> phong(const Vec3<S>& rgb, S cosine, const Shading& shading) {
  const S c = std::clamp(std::abs(cosine), S(0), S(1));
  const S lit = static_cast<S>(shading.ambient) + static_cast<S>(shading.diffuse) * c;
  const S gloss = static_cast<S>(shading.specular) * std::pow(c, static_cast<S>(shading.shininess));
  return (rgb * lit + Vec3<S>::Constant(gloss)).cwiseMax(S(0)).cwiseMin(S(1));
}

/// Tones of Gooch et al. 1998: cool = blue + cool_share · rgb, warm = yellow + warm_share · rgb.
inline constexpr double kGoochBlue = 0.4;
inline constexpr double kGoochYellow = 0.4;
/// Silhouettes are darkened by silhouette · (1 - |n · d|)^4.
inline constexpr int kSilhouettePower = 4;

/// Gooch shading from cool to warm. towards_light = n · l in [-1, 1]: n points to the eye, and l
/// points half up and half left in the rendered image. \p cosine: see phong().
template <class S>
Vec3<S> gooch(const Vec3<S>& rgb, S cosine, S towards_light, const Shading& shading) {
  const S warmth = S(0.5) * (S(1) + std::clamp(towards_light, S(-1), S(1)));
  const Vec3<S> cool =
      rgb * static_cast<S>(shading.cool_share) + Vec3<S>(0, 0, static_cast<S>(kGoochBlue));
  const Vec3<S> warm = rgb * static_cast<S>(shading.warm_share) +
                       Vec3<S>(static_cast<S>(kGoochYellow), static_cast<S>(kGoochYellow), 0);
  const S edge = S(1) - std::clamp(std::abs(cosine), S(0), S(1));
  const S dark = S(1) - static_cast<S>(shading.silhouette) * edge * edge * edge * edge;
  return (dark * (cool + warmth * (warm - cool))).cwiseMax(S(0)).cwiseMin(S(1));
}

/// Direction towards the light of gooch(): unit length, local mm.
template <class S>
Vec3<S> gooch_light(const View<S>& view) {
  return (view.up - view.right) * static_cast<S>(M_SQRT1_2);
}

/// Share of the shaded colour in a sample of importance I (Burns et al. 2007 §3.2).
template <class S>
S shaded_share(S importance, const Shading& shading) {
  return S(1) - static_cast<S>(shading.emphasis) * (S(1) - importance);
}

/// Limits of shades_of(): a pre-integrated cell is shaded at up to kMostShades positions. Its
/// weight decides the number.
inline constexpr int kMostShades = 4;
inline constexpr double kShadesPerRoot = 10;

/// Number n of positions at which a pre-integrated cell is shaded: at (j + 1/2) / n of the cell,
/// j < n. Their mean is the cell's colour. Gradients turn within a voxel. With one position per
/// cell the error is of order 1.3 in the step, while the rest of the integral has order 2. With n
/// positions the error of a cell falls by about n^-1.5. The cheapest image therefore has n grow
/// about with the square root of the cell's weight and of its length. \p weight: the cell's weight
/// in its pixel, [0, 1]. \p voxels: the length of the whole cell in units of the smallest spacing.
inline int shades_of(double weight, double voxels) {
  const double wanted = std::floor(kShadesPerRoot * std::sqrt(weight * voxels) + 0.5);
  return static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(kMostShades)));
}

/// Shades a volume sample with the normal n = gradient / |gradient|. The plain colour is blended to
/// the shaded colour by share · min(1, |gradient| / shading.full_gradient_per_mm). A zero gradient
/// leaves the colour unchanged. \p gradient: per mm, CT axes. \p light: gooch_light().
template <class S>
Vec3<S> shade_sample(const Vec3<S>& rgb, const Vec3<S>& gradient, const Vec3<S>& direction,
                     const Vec3<S>& light, S share, const Shading& shading) {
  const S norm = gradient.norm();
  if (!(norm > S(0)) || !(share > S(0))) return rgb;
  const S weight = share * std::min(S(1), norm / static_cast<S>(shading.full_gradient_per_mm));
  const S cosine = gradient.dot(direction) / norm;
  const S lit = gradient.dot(light) / norm;
  const Vec3<S> full = shading.style == ShadingStyle::kPhong
                           ? phong(rgb, cosine, shading)
                           : gooch(rgb, cosine, cosine > S(0) ? -lit : lit, shading);
  return rgb + weight * (full - rgb);
}

}  // namespace nav::render::spec
