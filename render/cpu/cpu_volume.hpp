// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "nav/volume.hpp"
#include "nav/zeroed_array.hpp"

namespace nav::render {

/// A volume in the layout of the CPU march, computed once per volume. Each voxel is stored beside
/// that of the next row, so that two loads of 8 bytes hold the eight voxels of a cell. The border
/// is repeated once below and twice above every axis, so that no load for a gradient needs a test.
class CpuVolume {
 public:
  /// Uses at most \p threads threads; 0: all cores.
  CpuVolume(const StoredVolume& ct, int threads);
  /// True when 32-bit voxel offsets suffice; a larger volume is rejected.
  static bool fits(const VoxelGrid& grid);

  /// Voxel (0, 0, 0) in the lower 16 bits, (0, 1, 0) in the upper ones; strides in voxels.
  [[nodiscard]] const std::int32_t* origin() const { return voxels_.data() + origin_; }
  [[nodiscard]] int row_stride() const { return row_stride_; }
  [[nodiscard]] int slice_stride() const { return slice_stride_; }
  /// Least and greatest value, HU.
  [[nodiscard]] int low_hu() const { return low_hu_; }
  [[nodiscard]] int high_hu() const { return high_hu_; }

 private:
  void copy_voxels(const StoredVolume& ct, int threads);
  void copy_slice(const StoredVolume& ct, int padded_k);

  /// Rays cross a slice with every sample, and each slice has its own memory pages. With large
  /// pages, the processor has all of them in its page table.
  ZeroedArray<std::int32_t> voxels_;
  std::size_t origin_ = 0;
  int row_stride_ = 0;
  int slice_stride_ = 0;
  int low_hu_ = 0;
  int high_hu_ = 0;
};

}  // namespace nav::render
