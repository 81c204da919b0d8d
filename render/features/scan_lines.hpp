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

#include "nav/ultrasound_image.hpp"
#include "nav/volume.hpp"
#include "render/features/run.hpp"
#include "render/features/volume.hpp"

namespace nav::render::features {

/// A unit vector in 32 bits: octahedral map with 16 bits per coordinate, error below 1e-4 rad.
struct PackedDirection {
  static constexpr std::uint32_t kNone = 0x80008000U;  ///< Undefined; no direction has these bits.
  std::uint32_t bits = kNone;
  static PackedDirection pack(const Eigen::Vector3d& unit);
  /// The unit vector; NaN when undefined.
  [[nodiscard]] Eigen::Vector3d unpack() const;
};

/// Scan lines of all voxels: unit directions away from the transducer in the volume's frame, and
/// depths along the scan line. Copying copies pointers; thread-safe.
class ScanLines {
 public:
  /// Parallel lines of a linear array. Depth 0 is in the plane through a point of its face,
  /// perpendicular to the direction. Rejects directions that are not finite or have length 0.
  static Result<ScanLines> parallel(const Direction<frames::Ct>& away,
                                    const Point<frames::Ct>& on_face);
  /// Lines from one apex in all directions (matrix or wobbler probes). Depth 0 is at the distance
  /// face_radius_mm >= 0 from the apex. Undefined at the apex itself.
  static Result<ScanLines> fan(const Point<frames::Ct>& apex, double face_radius_mm);
  /// A direction and a depth for every voxel of a grid. Rejects a different number of them.
  static Result<ScanLines> per_voxel(const VoxelGrid& grid, std::vector<PackedDirection> away,
                                     std::vector<float> depth_mm);

  /// Unit vector at a voxel of a grid; NaN if undefined. Lines per voxel are known only for the
  /// voxels of their own grid; see check().
  [[nodiscard]] Eigen::Vector3d away(const VoxelGrid& grid, int i, int j, int k) const;
  /// Depth of a voxel, mm; negative in front of the face; NaN if undefined.
  [[nodiscard]] double depth_mm(const VoxelGrid& grid, int i, int j, int k) const;
  /// Length of the line in front of a voxel, mm. For a fan it is the distance to the apex, where
  /// all lines begin. For other lines it is infinite, because their begin is unknown.
  [[nodiscard]] double before_mm(const VoxelGrid& grid, int i, int j, int k) const;
  /// The common direction, if all lines share one.
  [[nodiscard]] std::optional<Eigen::Vector3d> common() const;
  /// Rejects lines per voxel of a different grid. \p name: the feature that needs the lines.
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

/// One ultrasound image of a sweep: its pose and the area that its probe insonified.
struct SweepPlane {
  Transform<frames::Ct, frames::Image> ct_from_image;
  Eigen::Vector2d low_mm;                ///< Corner of the image, Image frame.
  Eigen::Vector2d high_mm;               ///< The opposite corner; depth is y.
  std::optional<SectorOutline> outline;  ///< No value: linear probe, lines along +y from y = 0.
};

/// Scan lines of a compounded sweep. Each voxel takes the mean direction and depth of the
/// ultrasound images that pass within reach_mm of it and insonified it, weighted by
/// 1 - distance / reach. Voxels are undefined if no image passed them or if directions cancel.
/// Takes 8 bytes per voxel. Rejects an empty list of images, a reach outside (0, 100] mm, and
/// images without extent.
Result<ScanLines> compound_scan_lines(const VoxelGrid& grid, std::span<const SweepPlane> planes,
                                      double reach_mm, const RunOptions& run = {});

/// Depth along the scan line per voxel, mm; NaN if undefined.
Result<FeatureVolume> scan_depth(const VoxelGrid& grid, const ScanLines& lines,
                                 const RunOptions& run = {});

}  // namespace nav::render::features
