// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_cutaway.hpp"

/// Selection of the objects of a cutaway that may decide for a block of pixels. See cpu_kernel.hpp
/// for V and for the files that may include this.
///
/// A point q of an object, seen from an origin o, gives f = (q - c) · r - cot |across|, measured
/// from the foot of the reference point c. Rotating the ray by an angle changes f by at most
/// angle · (|q - c| + cot |q - o|). Shifting it changes f by at most shift · (1 + cot). An object
/// that stays below the value that another object reaches everywhere in the block decides nowhere.
namespace nav::render {

template <class V>
class CutCuller {
  using F = typename V::F;
  using M = typename V::M;
  using Kernel = CutKernel<V>;
  using Vector = typename Kernel::Vector;

 public:
  CutCuller(const CutObjects& objects, const CutBlock& block)
      : objects_(objects),
        block_(block),
        kernel_{objects},
        o_(Kernel::all(block.origin)),
        r_(Kernel::all(block.direction)) {}

  float cull(const CutChoice& in, CutChoice& out) {
    choose_polygons(in, out);
    for (int i = 0; i < in.edge_count; i += V::kLanes) bound_edges(in, i, out.upper);
    for (int i = 0; i < objects_.ball_count; ++i) bound_ball(objects_.balls[i]);
    out.edge_count = 0;
    // Edges are sorted by polygon, and so are the chosen polygons.
    int at = 0;
    for (int i = 0; i < in.edge_count; ++i) {
      const int polygon = objects_.edges[in.edges[i]].polygon;
      while (at < out.polygon_count && out.polygons[at] < polygon) ++at;
      if (at < out.polygon_count && out.polygons[at] == polygon && out.inside[at]) continue;
      if (out.upper[2 * i] < least_[0] && out.upper[2 * i + 1] < least_[1]) continue;
      out.edges[out.edge_count++] = in.edges[i];
    }
    // A point inside a polygon varies by no more than some point of its edges.
    return peak_ + slackest_;
  }

 private:
  struct Edges {
    alignas(32) float a[3][V::kLanes];
    alignas(32) float along[3][V::kLanes];
  };
  static Vector load(const float (*p)[V::kLanes]) {
    return {{V::load(p[0]), V::load(p[1]), V::load(p[2])}};
  }

  /// Greatest change of a value within the block, for points at most from_c and from_o away from c
  /// and o.
  [[nodiscard]] F slack(F from_c, F from_o, int k) const {
    const F cot = V::set(objects_.cot[k]);
    const F turned = V::mul(V::set(block_.angle), V::madd(cot, from_o, from_c));
    const F one = V::set(1.0F);
    // 0.01 mm covers rounding errors.
    return V::add(V::madd(V::set(block_.shift), V::add(one, cot), turned), V::set(0.01F));
  }

  void bound(F t, F slack, int k, int lanes, float* upper) {
    alignas(32) float low[V::kLanes];
    alignas(32) float high[V::kLanes];
    V::store(low, V::sub(t, slack));
    V::store(high, V::add(t, slack));
    for (int lane = 0; lane < lanes; ++lane) {
      if (low[lane] > least_[k]) least_[k] = low[lane];
      raise(0.5F * (low[lane] + high[lane]), 0.51F * (high[lane] - low[lane]));
      if (upper != nullptr) upper[2 * lane + k] = high[lane];
    }
  }

  void raise(float t, float slack) {
    if (t > peak_) peak_ = t;
    if (slack > slackest_) slackest_ = slack;
  }

  void bound_edges(const CutChoice& in, int first, float* upper) {
    const int left = in.edge_count - first;
    const int lanes = left < V::kLanes ? left : V::kLanes;
    Edges e;
    for (int lane = 0; lane < V::kLanes; ++lane) {
      const CutEdge& edge = objects_.edges[in.edges[first + (lane < lanes ? lane : 0)]];
      for (int i = 0; i < 3; ++i) {
        e.a[i][lane] = edge.a[i];
        e.along[i][lane] = edge.along[i];
      }
    }
    const Vector a = load(e.a);
    const Vector along = load(e.along);
    const Vector b = Kernel::along(a, V::set(1.0F), along);
    const Vector from = Kernel::along(a, V::set(-1.0F), o_);
    const F from_c = farther(a, b);
    const Vector eye_a = Kernel::along(from, V::set(block_.eye), r_);
    const F from_o = farther(eye_a, Kernel::along(eye_a, V::set(1.0F), along));
    F t[2];
    kernel_.edge(from, along, r_, t);
    for (int k = 0; k < 2; ++k) bound(t[k], slack(from_c, from_o, k), k, lanes, upper + 2 * first);
  }

  static F farther(const Vector& a, const Vector& b) {
    return V::sqrt(V::max(Kernel::dot(a, a), Kernel::dot(b, b)));
  }

  void bound_ball(const CutBall& ball) {
    F t[2] = {V::set(-1e30F), V::set(-1e30F)};
    kernel_.ball(ball, o_, r_, t);
    const Vector c = Kernel::all(ball.centre);
    const F radius = V::set(ball.radius);
    const F from_c = V::add(V::sqrt(Kernel::dot(c, c)), radius);
    const Vector eye = Kernel::along(Kernel::along(c, V::set(-1.0F), o_), V::set(block_.eye), r_);
    const F from_o = V::add(V::sqrt(Kernel::dot(eye, eye)), radius);
    for (int k = 0; k < 2; ++k) bound(t[k], slack(from_c, from_o, k), k, 1, nullptr);
  }

  void choose_polygons(const CutChoice& in, CutChoice& out) {
    out.polygon_count = 0;
    for (int i = 0; i < in.polygon_count; ++i) {
      const CutPolygon& polygon = objects_.polygons[in.polygons[i]];
      bool inside = in.inside[i];
      if (!inside && misses(polygon, inside)) continue;
      out.polygons[out.polygon_count] = in.polygons[i];
      out.inside[out.polygon_count] = inside;
      ++out.polygon_count;
      if (inside) {
        bound_inside(polygon);
      } else {
        const auto middle = kernel_.plane(polygon, o_, r_);
        if (V::any(kernel_.inside(polygon, middle.u, middle.v))) raise(first(middle.t), 0);
      }
    }
  }

  /// Bounds the plane: all rays hit it between the hits of the corner rays.
  void bound_inside(const CutPolygon& polygon) {
    const Vector eye = Kernel::along(o_, V::set(-block_.eye), r_);
    F from_c = V::set(0.0F);
    F from_o = V::set(0.0F);
    for (int i = 0; i < 4; ++i) {
      const Vector hit = Kernel::along(Kernel::all(block_.corner_origin[i]), corner(polygon, i).t,
                                       Kernel::all(block_.corner_direction[i]));
      const Vector seen = Kernel::along(hit, V::set(-1.0F), eye);
      from_c = V::max(from_c, V::sqrt(Kernel::dot(hit, hit)));
      from_o = V::max(from_o, V::sqrt(Kernel::dot(seen, seen)));
    }
    const F t = kernel_.plane(polygon, o_, r_).t;
    for (int k = 0; k < 2; ++k) bound(t, slack(from_c, from_o, k), k, 1, nullptr);
  }

  [[nodiscard]] typename Kernel::Plane corner(const CutPolygon& polygon, int i) const {
    return kernel_.plane(polygon, Kernel::all(block_.corner_origin[i]),
                         Kernel::all(block_.corner_direction[i]));
  }
  static float first(F x) {
    alignas(32) float lanes[V::kLanes];
    V::store(lanes, x);
    return lanes[0];
  }

  /// True when no ray of the block can meet the inside of the polygon. Sets inside when all rays
  /// meet it and it is flat enough.
  bool misses(const CutPolygon& polygon, bool& inside) const {
    const auto middle = kernel_.plane(polygon, o_, r_);
    const float facing = first(middle.facing);
    const float steepness = facing < 0 ? -facing : facing;
    if (polygon.normal[0] == 0 && polygon.normal[1] == 0 && polygon.normal[2] == 0) return true;
    if (steepness < 2 * block_.angle + 1e-3F) return false;
    float reach2 = 0;
    for (int i = 0; i < 4; ++i) {
      const auto c = corner(polygon, i);
      const float du = first(c.u) - first(middle.u);
      const float dv = first(c.v) - first(middle.v);
      const float square = du * du + dv * dv;
      reach2 = square > reach2 ? square : reach2;
    }
    const float distance2 = to_boundary2(polygon, first(middle.u), first(middle.v));
    if (distance2 < 1.1F * reach2 + 1e-3F) return false;
    if (!V::any(kernel_.inside(polygon, middle.u, middle.v))) return true;
    inside = steepness - block_.angle > objects_.sine[1] + 1e-4F;
    return false;
  }

  /// Squared distance of a point of the plane to the nearest edge.
  float to_boundary2(const CutPolygon& polygon, float u, float v) const {
    float least = 1e30F;
    for (int i = 0; i < polygon.edges; ++i) {
      const CutEdge& e = objects_.edges[polygon.first_edge + i];
      const float eu = e.u[1] - e.u[0];
      const float ev = e.v[1] - e.v[0];
      const float au = u - e.u[0];
      const float av = v - e.v[0];
      float s = (au * eu + av * ev) / (eu * eu + ev * ev + 1e-20F);
      s = s < 0 ? 0 : s > 1 ? 1 : s;
      const float du = au - s * eu;
      const float dv = av - s * ev;
      const float square = du * du + dv * dv;
      least = square < least ? square : least;
    }
    return least;
  }

  const CutObjects& objects_;
  const CutBlock& block_;
  Kernel kernel_;
  Vector o_;
  Vector r_;
  float least_[2] = {-1e30F, -1e30F};  ///< Reached everywhere in the block.
  float peak_ = -1e30F;                ///< Greatest value on the ray in the middle.
  float slackest_ = 0;                 ///< Greatest change of any value.
};

template <class V>
float cull_with(const CutObjects& objects, const CutBlock& block, const CutChoice& in,
                CutChoice& out) {
  return CutCuller<V>(objects, block).cull(in, out);
}

}  // namespace nav::render
