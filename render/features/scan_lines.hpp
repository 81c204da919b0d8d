// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nav/ultrasound_frame.hpp"
#include "nav/volume.hpp"
#include "render/features/run.hpp"
#include "render/features/volume.hpp"

namespace nav::render::features {

/// A unit vector in 32 bits: octahedral map, 16 bits a coordinate, off by less than 1e-4 rad.
struct PackedDirection {
  static constexpr std::uint32_t kNone = 0x80008000U;  ///< Undefined; no direction has these bits.
  std::uint32_t bits = kNone;
  static PackedDirection pack(const Eigen::Vector3d& unit);
  /// NaN when undefined.
  [[nodiscard]] Eigen::Vector3d unpack() const;
};

/// Where the sound of every voxel came from: unit directions away from the transducer in the
/// volume's frame and the depth along the scan line. Copying copies pointers; thread-safe.
class ScanLines {
 public:
  /// Parallel lines of a linear array: depth 0 in the plane through a point of its face, at right
  /// angles to the direction. Refuses directions that are not finite or of length 0.
  static Result<ScanLines> parallel(const Direction<frames::Ct>& away,
                                    const Point<frames::Ct>& on_face);
  /// Lines from one apex in all directions (matrix or wobbler probes); depth 0 at a distance of
  /// face_radius_mm >= 0 from it. Undefined at the apex itself.
  static Result<ScanLines> fan(const Point<frames::Ct>& apex, double face_radius_mm);
  /// A direction and a depth for every voxel of a grid. Refuses other numbers of them.
  static Result<ScanLines> per_voxel(const VoxelGrid& grid, std::vector<PackedDirection> away,
                                     std::vector<float> depth_mm);

  /// Unit vector at a voxel of a grid; NaN where undefined. Lines per voxel know only the voxels of
  /// their own grid; see check().
  [[nodiscard]] Eigen::Vector3d away(const VoxelGrid& grid, int i, int j, int k) const;
  /// Negative in front of the face; NaN where undefined.
  [[nodiscard]] double depth_mm(const VoxelGrid& grid, int i, int j, int k) const;
  /// How much of the line lies before a voxel, mm: to the apex of a fan, where all lines begin;
  /// infinite of other lines, which nothing is known to begin before.
  [[nodiscard]] double before_mm(const VoxelGrid& grid, int i, int j, int k) const;
  /// The one direction, when all lines share it.
  [[nodiscard]] std::optional<Eigen::Vector3d> common() const;
  /// Refuses lines per voxel of another grid. name: what needs them.
  [[nodiscard]] Result<void> check(const VoxelGrid& grid, const std::string& name) const;
  [[nodiscard]] std::string digest() const;

 private:
  enum class Kind { kParallel, kFan, kPerVoxel };
  struct KnownDigest;
  ScanLines();
  Kind kind_ = Kind::kParallel;
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d point_mm_ = Eigen::Vector3d::Zero();
  double face_radius_mm_ = 0;
  VoxelGrid grid_;
  std::shared_ptr<const std::vector<PackedDirection>> away_;
  std::shared_ptr<const std::vector<float>> depth_;
  std::shared_ptr<KnownDigest> digest_;  ///< Shared by copies.
};

/// One picture of a sweep: where it was and what its probe insonified.
struct SweepPlane {
  Transform<frames::Ct, frames::Image> ct_from_image;
  Eigen::Vector2d low_mm;                ///< Corner of the picture, Image frame.
  Eigen::Vector2d high_mm;               ///< The opposite one; depth is y.
  std::optional<SectorOutline> outline;  ///< Absent: linear, lines along +y from y = 0.
};

/// Scan lines of a compounded sweep: every voxel takes the mean direction and depth of the pictures
/// that pass within reach_mm of it and insonified it, weighted by 1 - distance / reach. Voxels that
/// none passed, or where directions cancel, are undefined. Holds 8 bytes per voxel.
/// Refuses: no pictures, reach outside (0, 100] mm, corners that are not apart.
Result<ScanLines> compound_scan_lines(const VoxelGrid& grid, std::span<const SweepPlane> planes,
                                      double reach_mm, const RunOptions& run = {});

/// Depth along the scan line per voxel, mm; NaN where undefined.
Result<FeatureVolume> scan_depth(const VoxelGrid& grid, const ScanLines& lines,
                                 const RunOptions& run = {});

}  // namespace nav::render::features
