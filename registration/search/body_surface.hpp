// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "nav/volume.hpp"

namespace nav::registration {

/// A point on the skin.
struct SkinPoint {
  Point<frames::Ct> place;
  Eigen::Vector3d inward;  ///< Unit, Ct.
};

/// The surface of the body in a CT at a coarse resolution. The body is everything that air
/// connected to the CT's sides does not reach. There is no skin where the CT ends within the body.
/// Thread-safe to read.
class BodySurface {
 public:
  /// Accepts any CT; one that shows no air has no skin.
  explicit BodySurface(const Volume& ct);
  /// Depth below the skin, mm. It is accurate to a few mm within ±kReachMm and clamped beyond;
  /// outside the CT it is the value at the border.
  [[nodiscard]] double depth_mm(const Point<frames::Ct>& p) const;
  /// Points on the skin about spacing_mm apart. Deterministic; empty if there is no skin.
  [[nodiscard]] std::vector<SkinPoint> points(double spacing_mm) const;

  static constexpr double kReachMm = 20;

 private:
  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] Eigen::Vector3d centre_of(int i, int j, int k) const;

  std::array<int, 3> size_{};     ///< Number of cells.
  Eigen::Vector3d cell_mm_;       ///< Along the voxel grid's axes.
  Eigen::Vector3d origin_ct_mm_;  ///< Centre of the first cell.
  Eigen::Matrix3d directions_;
  std::vector<std::uint8_t> body_;  ///< One value for each cell, 1: inside.
  std::vector<float> depth_;        ///< One value for each cell, mm.
};

}  // namespace nav::registration
