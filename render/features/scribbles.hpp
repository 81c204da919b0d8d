// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "nav/volume.hpp"
#include "render/features/volume.hpp"

namespace nav::render::features {

enum class Paint { kShow, kHide, kErase };

/// A line drawn by hand on a slice plane through the volume (Schulte zu Berge et al. 2014, §4.1).
struct Stroke {
  static constexpr double kFurthestMm = 1e6;
  std::vector<Point<frames::Ct>> points;  ///< In order; one point is a dot. Within kFurthestMm.
  Direction<frames::Ct> plane_normal;     ///< Normal of the slice; any length except 0.
  double radius_mm = 1;                   ///< (0, 1000].
  /// Half of the thickness that the slice represents, mm, > 0. 0: half a voxel along the normal, so
  /// that every voxel that the plane passes through is marked.
  double half_thickness_mm = 0;
  Paint paint = Paint::kShow;
};

/// Rejects strokes without points, with numbers that are not finite or out of range, or with a
/// point farther from the plane through the first point than half the thickness, because part of
/// such a stroke would mark nothing. The error names the point, its distance and the limit.
Result<void> check(const Stroke& stroke, const VoxelGrid& grid);

/// Voxels marked by strokes, one byte each. A later stroke replaces the marks under it, so no voxel
/// is both shown and hidden.
class ScribbleMask {
 public:
  static constexpr std::uint8_t kShowBit = 1;
  static constexpr std::uint8_t kHideBit = 2;

  /// Precondition: the grid is valid by validate(); otherwise a Bug.
  explicit ScribbleMask(const VoxelGrid& grid);

  struct Painted {
    std::size_t changed = 0;  ///< Number of voxels that had another paint or none.
    bool covers_any = false;  ///< True if voxels of the volume lie under the stroke.
  };
  /// Marks the voxels whose centres lie within radius_mm of the polyline and within
  /// half_thickness_mm of the plane through its first point. Rejects what check() rejects. Ignores
  /// the parts outside the volume.
  Result<Painted> add(const Stroke& stroke);
  void clear();

  [[nodiscard]] const VoxelGrid& grid() const { return grid_; }
  [[nodiscard]] const std::vector<std::uint8_t>& bits() const { return bits_; }

 private:
  void add_segment(const Stroke& stroke, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                   const Eigen::Vector3d& normal, double half_thickness, Painted& painted);
  VoxelGrid grid_;
  std::vector<std::uint8_t> bits_;
};

/// N+ and N- of each predicate: the number of marked voxels for which it is true.
struct ScribbleCounts {
  std::vector<std::uint64_t> shown, hidden;
};
/// Counts the marked voxels. \p predicates_at: returns the bit mask of the predicates that are true
/// at a voxel (offset_of()). It is called only for marked voxels, in order. Precondition: 1 to 32
/// predicates.
ScribbleCounts count_scribbles(const ScribbleMask& mask, int predicates,
                               const std::function<std::uint32_t(std::size_t)>& predicates_at);

}  // namespace nav::render::features
