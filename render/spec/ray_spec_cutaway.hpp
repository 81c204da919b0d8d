// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "nav/volume.hpp"
#include "render/scene.hpp"
#include "render/spec/ray_spec_volume.hpp"

/// The contextual cutaway of Burns et al. 2007 §3.3 and §3.4, in closed form along a ray.
///
/// Cones are directed along the ray. A point q of the object clears the point p(t) at distance t on
/// a ray of direction r, at angle theta, when the angle between q - p(t) and r is at most theta.
/// The cutaway surface therefore meets the ray at
///   T(theta) = max over q of  (q - o) · r - cot(theta) |(q - o) - ((q - o) · r) r|.
/// For parallel rays this equals the paper's xi(theta) (there with the sign of eye space, z towards
/// the eye). An object never occludes itself along its own rays. Rays farther than theta from its
/// silhouette have T < 0 and stay unchanged. The other conventions in perspective (cones towards
/// the eye, cones along the view axis) agree near the axis and differ elsewhere. With
/// T2 = T(theta2) >= T1 = T(theta1) and d measured along the ray,
///   Omega(t) = (clamp((T2 - t) / (T2 - T1)) + clamp((T1 - t) / d)) / 2,
/// which is 0 in the base, 1/2 between transition and overlay, and 1 in the clear region.
namespace nav::render::spec {

/// A part of a cell has the mean visibility (or importance) of its two ends if these differ by no
/// more than this.
inline constexpr double kFadeVaries = 0.25;
/// Other parts are classified at this many equidistant values between the ends, each with its own
/// Omega.
inline constexpr int kFadeSteps = 4;
/// Number of chords that approximate the outer arc of a sector; the inner arc has the same angle
/// per chord. The largest distance to the arc is radius · (1 - cos(half_angle / 16)): 0.06 mm at
/// 120 mm and 30°.
inline constexpr int kSectorChords = 16;

/// An object of interest that cuts: a flat simple polygon or a segment (2 vertices).
template <class S>
struct CutawayPolygon {
  std::vector<Vec3<S>> vertices;  ///< Local mm.
  Vec3<S> normal;                 ///< Unit length; zero for a segment.
  Vec3<S> axis_u;  ///< Unit length, in the plane. axis_u and axis_v serve the inside test.
  Vec3<S> axis_v;
};
/// A triangle of a mesh. It has a fixed number of vertices, so that many triangles need no lists.
template <class S>
struct CutawayTriangle {
  std::array<Vec3<S>, 3> vertices;
  Vec3<S> normal;
  Vec3<S> axis_u;
  Vec3<S> axis_v;
};
template <class S>
struct CutawayBall {
  Vec3<S> centre;
  S radius;
};

/// All objects that cut, prepared for intersection with rays.
template <class S>
struct CutawayObjects {
  S cot1;
  S cot2;
  S overlay_mm;
  std::vector<CutawayPolygon<S>> polygons;
  std::vector<CutawayBall<S>> balls;
  [[nodiscard]] bool empty() const { return polygons.empty() && balls.empty(); }
};

/// Distances at which the surfaces of theta2 and theta1 meet a ray, mm. -infinity: they do not
/// meet.
template <class S>
struct CutawaySpan {
  S t2;
  S t1;
};

/// Omega at t. T2 = T1 and d = 0 give steps, without a division by 0.
template <class S>
S occlusion(const CutawaySpan<S>& span, S overlay_mm, S t) {
  if (!(t < span.t2)) return S(0);
  const S transition = span.t2 - span.t1;
  const S outer = transition > S(0) ? std::clamp((span.t2 - t) / transition, S(0), S(1)) : S(1);
  const S into = span.t1 - t;
  S inner = S(0);
  if (into > S(0)) inner = overlay_mm > S(0) ? std::min(into / overlay_mm, S(1)) : S(1);
  return S(0.5) * (outer + inner);
}

/// 1 - ramp(low, high, Omega).
template <class S>
S visibility_between(S low, S high, S omega) {
  if (omega <= low) return S(1);
  if (omega >= high) return S(0);
  return (high - omega) / (high - low);
}

/// Share of its opacity that a sample of importance I keeps: 1 - ramp(max(2 I - 1, 0), I, Omega).
/// The ramp tests its lower end first. The printed ramp does not; it makes I = 0 vanish in the base
/// and I = 1 vanish in the clear region.
template <class S>
S visibility(S importance, S omega) {
  return visibility_between(std::max(S(2) * importance - S(1), S(0)), importance, omega);
}

/// Share that a sample keeps in a cutaway, which may have constant thresholds.
inline double visibility(const Cutaway& cutaway, double importance, double omega) {
  if (!cutaway.constant) return visibility(importance, omega);
  return visibility_between(cutaway.constant->lower, cutaway.constant->upper, omega);
}

/// Importance of a quotient: it counts as 1 from kFullImportance on, so that rounding cannot hide
/// the most important sample.
template <class S>
S full_importance(S importance) {
  return importance >= static_cast<S>(kFullImportance) ? S(1) : importance;
}

/// Extinction after the fade, per mm. The fade acts on the opacity of 1 mm, before the step
/// correction. The other order would depend on the step.
template <class S>
S faded(S tau_per_mm, S visible) {
  if (visible >= S(1)) return tau_per_mm;
  if (!(visible > S(0))) return S(0);
  return -std::log1p(visible * std::expm1(-tau_per_mm));
}

/// Distance t up to which a sample of importance I is invisible, mm. No sample of importance <= I
/// is needed in front of it. It is nearer to the eye than the exact position by more than the
/// rounding error of visibility(occlusion()) (kSkipUlps of the largest term), so that skipping
/// stays bit-identical. Not for constant thresholds. -infinity for I = 1 and for a ray that meets
/// no surface.
template <class S>
S visible_from(const CutawaySpan<S>& span, S overlay_mm, S importance) {
  constexpr S kNever = -std::numeric_limits<S>::infinity();
  constexpr S kSkipUlps = S(16) * std::numeric_limits<S>::epsilon();
  if (importance >= S(1) || !(span.t2 > kNever)) return kNever;
  if (importance <= S(0.5)) {
    const S margin = kSkipUlps * (std::abs(span.t2) + std::abs(span.t1));
    return span.t2 - S(2) * importance * (span.t2 - span.t1) - margin;
  }
  const S margin = kSkipUlps * (std::abs(span.t1) + overlay_mm);
  return span.t1 - (S(2) * importance - S(1)) * overlay_mm - margin;
}

/// Cone function (q - o) · r - cot |across| of one point q; `across` is the part of q - o across
/// the ray.
template <class S>
S cone_point(const Vec3<S>& q, const Ray<S>& ray, S cot) {
  const Vec3<S> m = q - ray.origin;
  const S along = m.dot(ray.direction);
  return along - cot * (m - along * ray.direction).norm();
}

/// Greatest cone_point() on the segment from a to b. The function is concave along the segment.
template <class S>
S cone_segment(const Vec3<S>& a, const Vec3<S>& b, const Ray<S>& ray, S cot) {
  const Vec3<S> from = a - ray.origin;
  const Vec3<S> edge = b - a;
  const S along_a = from.dot(ray.direction);
  const Vec3<S> across_a = from - along_a * ray.direction;
  const S rise = edge.dot(ray.direction);
  const Vec3<S> across = edge - rise * ray.direction;
  const S length = across.norm();
  // For an edge along the ray, the farther end decides.
  if (!(length > S(1e-6))) return std::max(cone_point(a, ray, cot), cone_point(b, ray, cot));
  const Vec3<S> e = across / length;
  const S foot = -across_a.dot(e);
  const S height = (across_a + foot * e).norm();
  const S slope = rise / length;
  S s = slope > S(0) ? length : S(0);
  if (std::abs(slope) < cot) {
    s = std::clamp(foot + height * slope / std::sqrt((cot - slope) * (cot + slope)), S(0), length);
  }
  return along_a + slope * s - cot * std::hypot(s - foot, height);
}

/// True when a point of the plane of a CutawayPolygon or CutawayTriangle is inside, by the even-odd
/// rule.
template <class S, class Polygon>
bool inside_polygon(const Polygon& polygon, const Vec3<S>& p) {
  const S u = p.dot(polygon.axis_u);
  const S v = p.dot(polygon.axis_v);
  bool inside = false;
  const std::size_t n = polygon.vertices.size();
  for (std::size_t i = 0, j = n - 1; i < n; j = i++) {
    const S ui = polygon.vertices[i].dot(polygon.axis_u);
    const S vi = polygon.vertices[i].dot(polygon.axis_v);
    const S uj = polygon.vertices[j].dot(polygon.axis_u);
    const S vj = polygon.vertices[j].dot(polygon.axis_v);
    if ((vi > v) != (vj > v) && u < (uj - ui) * (v - vi) / (vj - vi) + ui) inside = !inside;
  }
  return inside;
}

/// Greatest cone_point() over a CutawayPolygon or CutawayTriangle. If the ray meets the plane
/// inside the polygon and the plane is less steep than the cone, the point on the ray is the
/// maximum. It is the only maximum because the function is concave. Otherwise the greatest value
/// lies on an edge, whether the polygon is convex or not.
template <class S, class Polygon>
S cone_polygon(const Polygon& polygon, const Ray<S>& ray, S cot) {
  const S facing = polygon.normal.dot(ray.direction);
  if (std::abs(facing) > S(0)) {
    const S steep = (polygon.normal - facing * ray.direction).norm();
    if (steep <= cot * std::abs(facing)) {
      const S t = polygon.normal.dot(polygon.vertices[0] - ray.origin) / facing;
      if (inside_polygon<S>(polygon, ray.origin + t * ray.direction)) return t;
    }
  }
  S best = -std::numeric_limits<S>::infinity();
  const std::size_t n = polygon.vertices.size();
  for (std::size_t i = 0, j = n - 1; i < n; j = i++) {
    best = std::max(best, cone_segment(polygon.vertices[j], polygon.vertices[i], ray, cot));
  }
  return best;
}

/// Greatest cone_point() over a ball. It lies at the point whose normal is opposite to the
/// gradient, unless that point lies beyond the axis. Then it lies at the point where the ray leaves
/// the ball.
template <class S>
S cone_ball(const CutawayBall<S>& ball, const Ray<S>& ray, S cot) {
  const Vec3<S> m = ball.centre - ray.origin;
  const S along = m.dot(ray.direction);
  const S across = (m - along * ray.direction).norm();
  const S norm = std::hypot(S(1), cot);
  if (across >= ball.radius * cot / norm) return along - cot * across + ball.radius * norm;
  return along + std::sqrt(std::max(ball.radius * ball.radius - across * across, S(0)));
}

/// Intersection of both surfaces with a ray; t2 >= t1.
template <class S>
CutawaySpan<S> meet_cutaway(const CutawayObjects<S>& objects, const Ray<S>& ray) {
  CutawaySpan<S> span{-std::numeric_limits<S>::infinity(), -std::numeric_limits<S>::infinity()};
  for (const auto& polygon : objects.polygons) {
    span.t1 = std::max(span.t1, cone_polygon(polygon, ray, objects.cot1));
    span.t2 = std::max(span.t2, cone_polygon(polygon, ray, objects.cot2));
  }
  for (const auto& ball : objects.balls) {
    span.t1 = std::max(span.t1, cone_ball(ball, ray, objects.cot1));
    span.t2 = std::max(span.t2, cone_ball(ball, ray, objects.cot2));
  }
  span.t2 = std::max(span.t2, span.t1);  // Rounding could make t2 < t1.
  return span;
}

/// Size from which the CPU and GL engines search a mesh (cutaway_mesh.hpp): more triangles than
/// this. The result is the same. The reference always tests every triangle.
inline constexpr std::size_t kExactTriangles = 64;

/// The objects of a scene that cut, in double. Planes, needles and spheres cut only while they are
/// drawn. with_meshes adds the meshes triangle by triangle. Empty: no cutaway. Defined in
/// cutaway.cpp.
CutawayObjects<double> make_cutaway(const Scene& scene, bool with_meshes);

/// Makes a flat polygon from its vertices in order, local mm. It has no normal when the vertices
/// lie on a line.
CutawayPolygon<double> make_polygon(std::vector<Vec3<double>> vertices);

/// The outline of an ultrasound image, image mm: the rectangle of its pixels, or its sector, which
/// is expected to lie inside that rectangle.
std::vector<Vec2<double>> outline_of(const UltrasoundImage& frame);

}  // namespace nav::render::spec
