// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/transform.hpp"

namespace nav {

/// Positions of the voxel centres in CT coordinates (LPS, mm): p_ct = origin_mm + directions ·
/// (spacing_mm ∘ (i, j, k)).
struct VoxelGrid {
  std::array<int, 3> size{};                                 ///< Number of voxels along i, j, k.
  Eigen::Vector3d spacing_mm{1, 1, 1};                       ///< > 0.
  Eigen::Vector3d origin_mm{0, 0, 0};                        ///< Centre of voxel (0, 0, 0).
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();  ///< Orthonormal columns; may be
                                                             ///< left-handed.

  [[nodiscard]] std::size_t voxel_count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  [[nodiscard]] Point<frames::Ct> at(const Eigen::Vector3d& index) const {
    return {origin_mm + directions * spacing_mm.cwiseProduct(index)};
  }
  /// Continuous voxel index of a point.
  [[nodiscard]] Eigen::Vector3d index_of(const Point<frames::Ct>& p) const {
    return (directions.transpose() * (p.mm - origin_mm)).cwiseQuotient(spacing_mm);
  }
  [[nodiscard]] Point<frames::Ct> centre() const;
  /// Edge lengths of the box of voxel centres, extended by half a voxel at each side, mm.
  [[nodiscard]] Eigen::Vector3d extent_mm() const;
};

/// Rejects sizes < 1 or more than 2^31 voxels in all, spacing outside [1e-4, 1e3] mm, directions
/// that are not orthonormal within 1e-4, and origins that are not finite. \p name: the volume's
/// name in the message.
Result<void> validate(const VoxelGrid& grid, const std::string& name);

/// HU of air; used outside a volume.
inline constexpr std::int16_t kAirHu = -1024;

/// CT volume in Hounsfield units. A copy shares the voxels, which never change. Reading is
/// thread-safe. Voxel order: i fastest, then j, then k.
class Volume {
 public:
  /// Rejects an invalid grid or a voxel count that does not match it.
  static Result<Volume> create(const VoxelGrid& grid, std::vector<std::int16_t> hu,
                               std::string name);

  [[nodiscard]] const VoxelGrid& grid() const { return grid_; }
  [[nodiscard]] std::span<const std::int16_t> hu() const { return *hu_; }
  /// Name of the volume in messages: file name or phantom name.
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::int16_t at(int i, int j, int k) const;
  /// Trilinear value at a point, HU; absent outside the box of voxel centres.
  [[nodiscard]] std::optional<double> sample(const Point<frames::Ct>& p) const;

 private:
  Volume(const VoxelGrid& grid, std::shared_ptr<const std::vector<std::int16_t>> hu,
         std::string name)
      : grid_(grid), hu_(std::move(hu)), name_(std::move(name)) {}
  VoxelGrid grid_;
  std::shared_ptr<const std::vector<std::int16_t>> hu_;
  std::string name_;
};

}  // namespace nav
