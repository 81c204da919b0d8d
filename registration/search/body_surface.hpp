// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "nav/volume.hpp"

namespace nav::registration {

/// A place on the skin.
struct SkinPoint {
  Point<frames::Ct> place;
  Eigen::Vector3d inward;  ///< Unit, Ct.
};

/// The outside of the body in a CT, coarsely: everything that air does not reach from the CT's
/// sides. Where the CT ends within the body there is no skin. Thread-safe to read.
class BodySurface {
 public:
  /// Any CT; one that shows no air has no skin.
  explicit BodySurface(const Volume& ct);
  /// Depth below the skin, mm, right to a few mm within ±kReachMm and held there beyond; outside
  /// the CT: as at its border.
  [[nodiscard]] double depth_mm(const Point<frames::Ct>& p) const;
  /// Points of the skin about spacing_mm apart. Deterministic; empty without skin.
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

  std::array<int, 3> size_{};     ///< In cells.
  Eigen::Vector3d cell_mm_;       ///< Along the voxel grid's axes.
  Eigen::Vector3d origin_ct_mm_;  ///< Centre of the first cell.
  Eigen::Matrix3d directions_;
  std::vector<std::uint8_t> body_;  ///< By cell, 1: inside.
  std::vector<float> depth_;        ///< By cell, mm.
};

}  // namespace nav::registration
