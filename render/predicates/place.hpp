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

/// What is wrong with predicates, or with what they are to be applied to.
inline Error malformed_predicates(const std::string& text) {
  return {ErrorCode::kMalformedData, text};
}

/// Scan lines side by side, as of a linear probe that is swept without turning.
struct ParallelScan {
  Point<frames::Ct> face_ct;      ///< Any point of the plane of depth 0.
  Direction<frames::Ct> into_ct;  ///< Away from the probe; any length > 0.
};

/// Scan lines from one point, as of a convex or mechanical 3D probe.
struct FanScan {
  Point<frames::Ct> apex_ct;
  double face_radius_mm = 0;  ///< Depth 0 is this far from the apex, >= 0.
};

/// A direction of its own for each voxel, as of a compounded sweep; depth is then a feature volume.
struct VoxelScan {
  /// One per voxel, i fastest, CT axes, any length; a zero or a NaN: unknown there.
  std::shared_ptr<const std::vector<Eigen::Vector3f>> into_ct;
};

/// Where the ultrasound came from.
using ScanGeometry = std::variant<ParallelScan, FanScan, VoxelScan>;

/// Both absent, or the same numbers, or the same directions of voxels in one place.
bool same_scan(const std::optional<ScanGeometry>& a, const std::optional<ScanGeometry>& b);

/// Refuses zero directions, NaN, a negative radius, a number of directions other than the grid's.
Result<void> validate(const ScanGeometry& scan, const VoxelGrid& grid);

/// A straight piece, in "grid mm": spacing ∘ index, so that its axes are those of the grid.
struct Segment {
  Eigen::Vector3d a;
  Eigen::Vector3d b;
  double radius_mm;  ///< Distances count from this far off the axis.
};

/// What predicates may know of the scene around the volume.
struct PredicatePlace {
  VoxelGrid grid;
  std::optional<ScanGeometry> scan;
  std::optional<Segment> needle;  ///< NaN while it is lost: no distance is within any range.
  std::optional<Segment> target;  ///< A ball: a = b.

  /// A CT point in grid mm.
  [[nodiscard]] Eigen::Vector3d grid_mm(const Point<frames::Ct>& p) const {
    return grid.directions.transpose() * (p.mm - grid.origin_mm);
  }
};

/// Of one volume: whether places in it lie the same to the scan, the needle and the target. Never
/// with a lost needle.
bool same_surroundings(const PredicatePlace& a, const PredicatePlace& b);

}  // namespace nav::render
