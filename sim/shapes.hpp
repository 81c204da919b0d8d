// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

/// Signed distances in mm, negative inside. Ellipsoids are first-order distances: exact on the
/// surface, with slope near one around it.
namespace nav::sim::shapes {

using Vec = Eigen::Vector3d;

struct Ellipsoid {
  Vec centre;
  Vec radii;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< Columns: its axes.
  [[nodiscard]] double operator()(const Vec& p) const {
    const Vec q = axes.transpose() * (p - centre);
    const Vec scaled = q.cwiseQuotient(radii);
    const double k0 = scaled.norm();
    const double k1 = scaled.cwiseQuotient(radii).norm();
    if (k1 < 1e-9) return -radii.minCoeff();
    return k0 * (k0 - 1.0) / k1;
  }
};

struct Capsule {
  Vec from;
  Vec to;
  double radius;
  [[nodiscard]] double operator()(const Vec& p) const { return axis_distance(p) - radius; }
  [[nodiscard]] double axis_distance(const Vec& p) const {
    const Vec along = to - from;
    const Vec offset = p - from;
    const double t = std::clamp(offset.dot(along) / along.squaredNorm(), 0.0, 1.0);
    return (offset - t * along).norm();
  }
};

/// Shortest distance between two segments' axes, sampled finely enough for clearance tests.
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
inline double smooth_union(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k * 0.25;
}
inline double smooth_intersection(double a, double b, double k) { return -smooth_union(-a, -b, k); }
/// a without b.
inline double smooth_difference(double a, double b, double k) {
  return smooth_intersection(a, -b, k);
}

/// Cross-section |x/a|^2.5 + |y/b|^2.5 = 1, endless along z.
struct SuperEllipse {
  double a;
  double b;
  [[nodiscard]] double gauge(double x, double y) const {
    const double u = std::abs(x) / a;
    const double v = std::abs(y) / b;
    return std::pow(u * u * std::sqrt(u) + v * v * std::sqrt(v), 0.4);
  }
  [[nodiscard]] double operator()(const Vec& p) const {
    const double u = std::abs(p.x()) / a;
    const double v = std::abs(p.y()) / b;
    const double sum = u * u * std::sqrt(u) + v * v * std::sqrt(v);
    if (sum < 1e-9) return -std::min(a, b);
    const double k = std::pow(sum, 0.4);
    const double slope = k / sum * std::hypot(u * std::sqrt(u) / a, v * std::sqrt(v) / b);
    return (k - 1.0) / slope;
  }
};

}  // namespace nav::sim::shapes
