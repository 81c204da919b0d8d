// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace nav {

/// Triangle mesh in CT coordinates, as read from a file: possibly open, with either orientation.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> points_mm;     ///< Ct, LPS.
  std::vector<std::array<int, 3>> triangles;  ///< Indices into points_mm.
  std::string name;                           ///< Name for messages.
};

}  // namespace nav
