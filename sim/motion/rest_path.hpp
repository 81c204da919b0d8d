// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/motion/warp.hpp"

namespace nav::sim {

/// Path of a straight line through moving tissue, mapped to the tissue at rest, where it is curved:
/// the tissue that a beam meets. It is cubic between nodes 6 mm apart, whose positions and
/// directions come from the warp. For motion as smooth as breathing the error is below 0.01 mm
/// (docs/simulator.md). Through tissue at rest it is exactly the straight line. Reading is
/// thread-safe.
class RestPath {
 public:
  /// \p warp: motion of the tissue; nullptr: at rest. The line begins at \p start (Ct, mm, now) and
  /// has the direction \p along and length_mm > 0. \p across: a second direction to follow. Both
  /// directions have length 1.
  RestPath(const Warp* warp, const Eigen::Vector3d& start, const Eigen::Vector3d& along,
           const Eigen::Vector3d& across, double length_mm);

  /// Position at rest, mm, of the point that is now depth_mm along the line and off_mm beside it.
  /// The depth is clamped to the length. First order in off_mm.
  [[nodiscard]] Eigen::Vector3d at(double depth_mm, double off_mm = 0) const {
    return nodes_.empty() ? start_ + depth_mm * along_ + off_mm * across_
                          : curved(depth_mm, off_mm);
  }
  /// Direction of the line at rest, length 1.
  [[nodiscard]] Eigen::Vector3d direction(double depth_mm) const;

  /// The path mapped by a linear map of space.
  [[nodiscard]] RestPath mapped(const Eigen::Matrix3d& map) const;

 private:
  struct Node {
    Eigen::Vector3d place, along, across;  ///< along, across: per mm now.
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
