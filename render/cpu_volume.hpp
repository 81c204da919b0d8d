// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nav/volume.hpp"

namespace nav::render {

/// Voxels along one edge of a brick; what a leap cannot see inside of.
inline constexpr int kBrickVoxels = 8;

/// A volume as the CPU marches through it, computed once per volume: voxels with their border
/// repeated once below and twice above every axis, so that no fetch of a gradient needs a test;
/// and the range of every brick. Brick b holds the samples whose lower voxel is in [8b, 8b + 8),
/// so its range includes one voxel beyond (the apron).
class CpuVolume {
 public:
  /// Uses at most threads threads; 0: all cores.
  CpuVolume(const Volume& ct, int threads);
  /// Whether 32-bit voxel offsets suffice; beyond that the volume is refused.
  static bool fits(const VoxelGrid& grid);

  /// Voxel (0, 0, 0); strides in voxels.
  [[nodiscard]] const std::int16_t* origin() const { return voxels_.data() + origin_; }
  [[nodiscard]] int row_stride() const { return row_stride_; }
  [[nodiscard]] int slice_stride() const { return slice_stride_; }
  [[nodiscard]] const std::array<int, 3>& bricks() const { return bricks_; }
  [[nodiscard]] int brick_count() const { return bricks_[0] * bricks_[1] * bricks_[2]; }
  [[nodiscard]] std::int16_t brick_min(int brick) const {
    return brick_min_[static_cast<std::size_t>(brick)];
  }
  [[nodiscard]] std::int16_t brick_max(int brick) const {
    return brick_max_[static_cast<std::size_t>(brick)];
  }

 private:
  void copy_voxels(const Volume& ct, int threads);
  void find_ranges(const Volume& ct, int threads);

  std::vector<std::int16_t> voxels_;
  std::size_t origin_ = 0;
  int row_stride_ = 0;
  int slice_stride_ = 0;
  std::array<int, 3> bricks_{};
  std::vector<std::int16_t> brick_min_;
  std::vector<std::int16_t> brick_max_;
};

}  // namespace nav::render
