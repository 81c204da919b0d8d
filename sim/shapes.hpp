// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "sim/anatomy/dual.hpp"

/// Signed distances of double or Dual positions, mm, negative inside. Distances of ellipsoids are
/// of first order: exact on the surface, with a slope near one around it.
namespace nav::sim::shapes {

using Vec = Eigen::Vector3d;

struct Ellipsoid {
  Vec centre;
  Vec radii;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< Columns: the axes of the ellipsoid.
  [[nodiscard]] double operator()(const Vec& p) const { return distance(p); }
  [[nodiscard]] Dual operator()(const Vec3Dual& p) const { return distance(p); }
  template <class S>
  [[nodiscard]] S distance(const Vec3<S>& p) const {
    const Vec3<S> q = axes.transpose().template cast<S>() * (p - centre.template cast<S>());
    const Vec3<S> scaled = q.cwiseQuotient(radii.template cast<S>());
    const S k0 = scaled.norm();
    const S k1 = scaled.cwiseQuotient(radii.template cast<S>()).norm();
    if (k1 < 1e-9) return S(-radii.minCoeff());
    return k0 * (k0 - 1.0) / k1;
  }
};

struct Capsule {
  Vec from;
  Vec to;
  double radius;
  [[nodiscard]] double operator()(const Vec& p) const { return axis_distance(p) - radius; }
  [[nodiscard]] Dual operator()(const Vec3Dual& p) const { return off_axis(p) - radius; }
  [[nodiscard]] double axis_distance(const Vec& p) const { return off_axis(p); }
  template <class S>
  [[nodiscard]] S off_axis(const Vec3<S>& p) const {
    const Vec along = to - from;
    const Vec3<S> offset = p - from.template cast<S>();
    const S share = offset.dot(along.template cast<S>()) / S(along.squaredNorm());
    const S t = std::clamp(share, S(0.0), S(1.0));
    return (offset - t * along.template cast<S>()).norm();
  }
};

/// Shortest distance between the axes of two capsules, sampled finely enough for clearance tests.
inline double axis_gap(const Capsule& a, const Capsule& b) {
  double gap = 1e9;
  constexpr int kSamples = 6;
  for (int i = 0; i <= kSamples; ++i) {
    const double t = static_cast<double>(i) / kSamples;
    gap = std::min(gap, a.axis_distance(b.from + t * (b.to - b.from)));
    gap = std::min(gap, b.axis_distance(a.from + t * (a.to - a.from)));
  }
  return gap;
}

/// Union with a fillet of width k mm (polynomial smooth minimum, Quilez).
template <class S>
S smooth_union(const S& a, const S& b, double k) {
  using std::abs;
  const S h = std::max(k - abs(a - b), S(0.0)) / S(k);
  return std::min(a, b) - h * h * k * 0.25;
}
template <class S>
S smooth_intersection(const S& a, const S& b, double k) {
  return -smooth_union(S(-a), S(-b), k);
}
/// The part of a outside b.
template <class S>
S smooth_difference(const S& a, const S& b, double k) {
  return smooth_intersection(a, S(-b), k);
}

/// 0 for t < 0, 1 for t > 1, a smooth cubic between.
template <class S>
S smooth_step(const S& t) {
  const S s = std::clamp(t, S(0.0), S(1.0));
  return s * s * (3.0 - 2.0 * s);
}

/// Cross-section |x/a|^2.5 + |y/b|^2.5 = 1, infinite along z.
struct SuperEllipse {
  double a;
  double b;
  [[nodiscard]] double gauge(double x, double y) const {
    const double u = std::abs(x) / a;
    const double v = std::abs(y) / b;
    return std::pow(u * u * std::sqrt(u) + v * v * std::sqrt(v), 0.4);
  }
  [[nodiscard]] double operator()(const Vec& p) const { return distance(p); }
  [[nodiscard]] Dual operator()(const Vec3Dual& p) const { return distance(p); }
  template <class S>
  [[nodiscard]] S distance(const Vec3<S>& p) const {
    using std::abs, std::hypot, std::pow, std::sqrt;
    const S u = abs(p.x()) / S(a);
    const S v = abs(p.y()) / S(b);
    const S sum = u * u * sqrt(u) + v * v * sqrt(v);
    if (sum < 1e-9) return S(-std::min(a, b));
    const S k = pow(sum, 0.4);
    const S slope = k / sum * hypot(u * sqrt(u) / S(a), v * sqrt(v) / S(b));
    return (k - 1.0) / slope;
  }
};

}  // namespace nav::sim::shapes
