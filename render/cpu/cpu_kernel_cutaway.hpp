// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_cutaway.hpp"

/// spec::meet_cutaway() in lanes: several rays with one edge, or several edges with one ray. See
/// cpu_kernel.hpp for V and for the files that may include this.
namespace nav::render {

template <class V>
struct CutKernel {
  using F = typename V::F;
  using M = typename V::M;

  const CutObjects& objects;  ///< Must outlive this.

  struct Vector {
    F x[3];
  };

  static Vector all(const float* p) { return {{V::set(p[0]), V::set(p[1]), V::set(p[2])}}; }
  static F dot(const Vector& a, const Vector& b) {
    return V::madd(a.x[0], b.x[0], V::madd(a.x[1], b.x[1], V::mul(a.x[2], b.x[2])));
  }
  /// a + s b.
  static Vector along(const Vector& a, F s, const Vector& b) {
    Vector out;
    for (int i = 0; i < 3; ++i) out.x[i] = V::madd(s, b.x[i], a.x[i]);
    return out;
  }
  static F minus(F a) { return V::sub(V::set(0.0F), a); }
  static F root(F a) { return V::sqrt(V::max(a, V::set(0.0F))); }

  /// spec::cone_segment() for both angles.
  void edge(const Vector& from, const Vector& edge, const Vector& r, F* t) const {
    const F along_a = dot(from, r);
    const Vector across_a = along(from, minus(along_a), r);
    const F rise = dot(edge, r);
    const Vector across = along(edge, minus(rise), r);
    // An edge along the ray: its slope is practically infinite, so the farther end decides.
    const F length = V::max(root(dot(across, across)), V::set(1e-6F));
    const F per_length = V::div(V::set(1.0F), length);
    const M leans = V::less(V::set(1e-6F), length);
    const F unit = V::mask(leans, per_length);
    const F foot = minus(V::mul(dot(across_a, across), unit));
    const Vector nearest = along(across_a, V::mul(foot, unit), across);
    const F height2 = dot(nearest, nearest);
    const F slope = V::mul(rise, per_length);
    for (int k = 0; k < 2; ++k) {
      const F cot = V::set(objects.cot[k]);
      const F end = V::select(V::less(V::set(0.0F), slope), length, V::set(0.0F));
      const M flat = V::less(V::abs(slope), cot);
      const F lean = V::mul(V::sub(cot, slope), V::add(cot, slope));
      const F per_lean = V::div(slope, V::sqrt(V::max(lean, V::set(1e-12F))));
      const F best = V::madd(V::sqrt(height2), per_lean, foot);
      const F inside = V::min(V::max(best, V::set(0.0F)), length);
      const F s = V::select(flat, inside, end);
      const F off = V::sub(s, foot);
      const F reach = V::sqrt(V::madd(off, off, height2));
      t[k] = V::sub(V::madd(slope, s, along_a), V::mul(cot, reach));
    }
  }

  /// spec::inside_polygon() for points in coordinates of the plane.
  M inside(const CutPolygon& polygon, F u, F v) const {
    M in = V::none();
    for (int i = 0; i < polygon.edges; ++i) {
      const CutEdge& e = objects.edges[polygon.first_edge + i];
      const M spans = V::exclusive(V::less(v, V::set(e.v[0])), V::less(v, V::set(e.v[1])));
      const F at = V::madd(V::sub(v, V::set(e.v[0])), V::set(e.u_per_v), V::set(e.u[0]));
      in = V::exclusive(in, V::both(spans, V::less(u, at)));
    }
    return in;
  }

  struct Plane {
    F t;  ///< Distance at which the rays meet the plane.
    F u;
    F v;
    F facing;
  };
  Plane plane(const CutPolygon& polygon, const Vector& o, const Vector& r) const {
    const Vector normal = all(polygon.normal);
    const F facing = dot(normal, r);
    const Vector to = along(all(polygon.vertex), V::set(-1.0F), o);
    const M seen = V::less(V::set(0.0F), V::abs(facing));
    const F t = V::div(dot(normal, to), V::select(seen, facing, V::set(1.0F)));
    const Vector p = along(o, t, r);
    return {t, dot(p, all(polygon.axis_u)), dot(p, all(polygon.axis_v)), facing};
  }

  /// Uses the plane itself if the ray passes inside the polygon and the plane is less steep than
  /// the cone. \p sure: both are known to be true.
  void interior(const CutPolygon& polygon, bool sure, const Vector& o, const Vector& r,
                F* best) const {
    const Plane p = plane(polygon, o, r);
    if (sure) {
      for (int k = 0; k < 2; ++k) best[k] = V::max(best[k], p.t);
      return;
    }
    const M in = inside(polygon, p.u, p.v);
    if (!V::any(in)) return;
    const F facing = V::abs(p.facing);
    const Vector off = along(all(polygon.normal), minus(p.facing), r);
    const F steep = root(dot(off, off));
    for (int k = 0; k < 2; ++k) {
      const M flat = V::not_less(V::mul(V::set(objects.cot[k]), facing), steep);
      const M mine = V::both(V::both(in, flat), V::less(V::set(0.0F), facing));
      best[k] = V::select(mine, V::max(best[k], p.t), best[k]);
    }
  }

  /// spec::cone_ball().
  void ball(const CutBall& ball, const Vector& o, const Vector& r, F* best) const {
    const Vector m = along(all(ball.centre), V::set(-1.0F), o);
    const F middle = dot(m, r);
    const Vector off = along(m, minus(middle), r);
    const F across2 = dot(off, off);
    const F across = V::sqrt(across2);
    const F radius = V::set(ball.radius);
    const F behind = V::add(middle, root(V::sub(V::mul(radius, radius), across2)));
    for (int k = 0; k < 2; ++k) {
      const F cot = V::set(objects.cot[k]);
      const F norm = V::set(objects.per_sine[k]);  // hypot(1, cot)
      const F side = V::madd(radius, norm, V::sub(middle, V::mul(cot, across)));
      const M outside = V::not_less(V::mul(across, norm), V::mul(radius, cot));
      best[k] = V::max(best[k], V::select(outside, side, behind));
    }
  }

  void meet(const CutChoice& choice, CutRays& rays, int lane) const {
    Vector o;
    Vector r;
    for (int i = 0; i < 3; ++i) {
      o.x[i] = V::load(rays.origin[i] + lane);
      r.x[i] = V::load(rays.direction[i] + lane);
    }
    F best[2] = {V::set(-1e30F), V::set(-1e30F)};
    for (int i = 0; i < choice.polygon_count; ++i) {
      interior(objects.polygons[choice.polygons[i]], choice.inside[i], o, r, best);
    }
    for (int i = 0; i < choice.edge_count; ++i) {
      const CutEdge& e = objects.edges[choice.edges[i]];
      F t[2];
      edge(along(all(e.a), V::set(-1.0F), o), all(e.along), r, t);
      for (int k = 0; k < 2; ++k) best[k] = V::max(best[k], t[k]);
    }
    for (int i = 0; i < objects.ball_count; ++i) ball(objects.balls[i], o, r, best);
    V::store(rays.t1 + lane, best[0]);
    V::store(rays.t2 + lane, V::max(best[0], best[1]));
  }
};

template <class V>
void meet_with(const CutObjects& objects, const CutChoice& choice, CutRays& rays) {
  for (int lane = 0; lane < kPacketLanes; lane += V::kLanes) {
    CutKernel<V>{objects}.meet(choice, rays, lane);
  }
}

}  // namespace nav::render
