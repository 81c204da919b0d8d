// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/motion/warp.hpp"

namespace nav::sim {

/// A straight line through moving tissue as that tissue lay at rest, where it is curved: what a
/// beam meets. Cubic between nodes 6 mm apart, at each of which position and direction come from
/// the warp: within 0.01 mm of it for motion as smooth as breathing (docs/simulator.md); a line
/// through tissue at rest stays the straight line, to the last bit. Thread-safe to read.
class RestPath {
 public:
  /// warp: where the tissue has gone, nullptr: at rest. From start (Ct, mm, now) for length_mm > 0
  /// along a direction; across: a second direction to follow. Both of length 1.
  RestPath(const Warp* warp, const Eigen::Vector3d& start, const Eigen::Vector3d& along,
           const Eigen::Vector3d& across, double length_mm);

  /// Position at rest, mm, of what is off_mm beside the line now, depth_mm along it, clamped to the
  /// length. First order in off_mm.
  [[nodiscard]] Eigen::Vector3d at(double depth_mm, double off_mm = 0) const {
    return nodes_.empty() ? start_ + depth_mm * along_ + off_mm * across_
                          : curved(depth_mm, off_mm);
  }
  /// Direction of the line at rest, length 1.
  [[nodiscard]] Eigen::Vector3d direction(double depth_mm) const;

  /// The same path under a linear map of space.
  [[nodiscard]] RestPath mapped(const Eigen::Matrix3d& map) const;

 private:
  struct Node {
    Eigen::Vector3d place, along, across;  ///< The last two per mm now.
  };
  struct Place {
    std::size_t node;
    double share;
  };
  [[nodiscard]] Place place(double depth_mm) const;
  [[nodiscard]] Eigen::Vector3d curved(double depth_mm, double off_mm) const;

  Eigen::Vector3d start_, along_, across_;
  double spacing_mm_ = 0;
  std::vector<Node> nodes_;
};

}  // namespace nav::sim
