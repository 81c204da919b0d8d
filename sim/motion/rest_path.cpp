// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/rest_path.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "nav/check.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kNodeMm = 6;

}  // namespace

RestPath::RestPath(const Warp* warp, const Vec& start, const Vec& along, const Vec& across,
                   double length_mm)
    : start_(start), along_(along), across_(across) {
  NAV_CHECK(length_mm > 0, length_mm);
  if (warp == nullptr) return;
  const int pieces = std::max(1, static_cast<int>(std::ceil(length_mm / kNodeMm)));
  spacing_mm_ = length_mm / pieces;
  nodes_.reserve(static_cast<std::size_t>(pieces) + 1);
  for (int i = 0; i <= pieces; ++i) {
    const Vec rest = warp->invert(start + i * spacing_mm_ * along);
    const Eigen::Matrix3d back = warp->jacobian(rest).inverse();
    nodes_.push_back({rest, back * along, back * across});
  }
}

RestPath::Place RestPath::place(double depth_mm) const {
  const double at = std::clamp(depth_mm / spacing_mm_, 0.0, static_cast<double>(nodes_.size() - 1));
  const std::size_t node = std::min(static_cast<std::size_t>(at), nodes_.size() - 2);
  return {node, at - static_cast<double>(node)};
}

Vec RestPath::curved(double depth_mm, double off_mm) const {
  const auto [node, t] = place(depth_mm);
  const Node& a = nodes_[node];
  const Node& b = nodes_[node + 1];
  // Hermite interpolation: value and slope of both ends.
  const double s = 1 - t;
  return s * s * ((1 + 2 * t) * a.place + t * spacing_mm_ * a.along) +
         t * t * ((1 + 2 * s) * b.place - s * spacing_mm_ * b.along) +
         off_mm * (s * a.across + t * b.across);
}

Vec RestPath::direction(double depth_mm) const {
  if (nodes_.empty()) return along_;
  const auto [node, t] = place(depth_mm);
  return ((1 - t) * nodes_[node].along + t * nodes_[node + 1].along).normalized();
}

RestPath RestPath::mapped(const Eigen::Matrix3d& map) const {
  RestPath out = *this;
  out.start_ = map * start_;
  out.along_ = map * along_;
  out.across_ = map * across_;
  for (Node& node : out.nodes_) {
    node = {map * node.place, map * node.along, map * node.across};
  }
  return out;
}

}  // namespace nav::sim
