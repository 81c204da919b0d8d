// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "nav/volume.hpp"

namespace nav::render {

/// Error for invalid predicates, or for invalid data that they apply to.
inline Error malformed_predicates(const std::string& text) {
  return {ErrorCode::kMalformedData, text};
}

/// Parallel scan lines, as from a linear probe that is moved without rotation.
struct ParallelScan {
  Point<frames::Ct> face_ct;      ///< Any point of the plane with depth 0.
  Direction<frames::Ct> into_ct;  ///< Direction away from the probe; any length > 0.
};

/// Scan lines from one point, as from a convex or mechanical 3D probe.
struct FanScan {
  Point<frames::Ct> apex_ct;
  double face_radius_mm = 0;  ///< Distance of depth 0 from the apex, >= 0.
};

/// A separate scan direction for each voxel, as in a compounded sweep. Depth is then a feature
/// volume.
struct VoxelScan {
  /// One direction per voxel, i fastest, CT axes, any length. Zero or NaN: unknown.
  std::shared_ptr<const std::vector<Eigen::Vector3f>> into_ct;
};

/// The geometry of the scan lines.
using ScanGeometry = std::variant<ParallelScan, FanScan, VoxelScan>;

/// True when both are absent or both are equal. Two VoxelScans are equal when they share the same
/// array.
bool same_scan(const std::optional<ScanGeometry>& a, const std::optional<ScanGeometry>& b);

/// Rejects zero directions, NaN, a negative radius, and a number of directions other than the
/// grid's.
Result<void> validate(const ScanGeometry& scan, const VoxelGrid& grid);

/// A line segment in "grid mm": spacing ∘ index, along the axes of the grid.
struct Segment {
  Eigen::Vector3d a;
  Eigen::Vector3d b;
  double radius_mm;  ///< Distances count from this distance off the axis.
};

/// Scene data around the volume that predicates may use.
struct PredicatePosition {
  VoxelGrid grid;
  std::optional<ScanGeometry> scan;
  std::optional<Segment> needle;  ///< NaN while the needle is lost: then no distance is in range.
  std::optional<Segment> target;  ///< A ball with a = b.

  /// Converts a CT point to grid mm.
  [[nodiscard]] Eigen::Vector3d grid_mm(const Point<frames::Ct>& p) const {
    return grid.directions.transpose() * (p.mm - grid.origin_mm);
  }
};

/// True when the scan, the needle and the target lie in the same way to one volume. Never true with
/// a lost needle.
bool same_surroundings(const PredicatePosition& a, const PredicatePosition& b);

}  // namespace nav::render
