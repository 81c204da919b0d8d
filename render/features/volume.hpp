// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "nav/volume.hpp"

namespace nav::render::features {

inline constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// Offset of a voxel; i fastest, then j, then k.
inline std::size_t offset_of(const VoxelGrid& grid, int i, int j, int k) {
  return (static_cast<std::size_t>(k) * static_cast<std::size_t>(grid.size[1]) +
          static_cast<std::size_t>(j)) *
             static_cast<std::size_t>(grid.size[0]) +
         static_cast<std::size_t>(i);
}

/// The scalar voxels from which features are derived: the reconstructed ultrasound intensity. NaN
/// is a voxel that no ultrasound image reached. Copying copies pointers; immutable and thread-safe.
class ScalarVolume {
 public:
  /// Rejects an invalid grid, a number of values that does not match it, and infinities. NaN is
  /// "unknown".
  static Result<ScalarVolume> create(const VoxelGrid& grid, std::vector<float> values,
                                     std::string name);
  /// Shares the voxels of a volume. Voxels with the value \p unknown, if given, become NaN.
  static ScalarVolume of(std::shared_ptr<const StoredVolume> volume,
                         std::optional<std::int16_t> unknown = {});

  [[nodiscard]] const VoxelGrid& grid() const { return grid_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Copies the row (·, j, k) of size[0] values; unknown voxels are NaN.
  void read_row(int j, int k, float* out) const;
  [[nodiscard]] float at(int i, int j, int k) const;
  /// Step between neighbouring stored values: 1 for integers, 0 for float.
  [[nodiscard]] double quantum() const { return volume_ ? 1 : 0; }
  /// Digest of grid and values, SHA-256 as 64 hexadecimal digits. The first call reads the voxels.
  [[nodiscard]] std::string digest() const;

 private:
  ScalarVolume();
  VoxelGrid grid_;
  std::string name_;
  std::shared_ptr<const StoredVolume> volume_;         ///< Either this,
  std::optional<VolumeOf<frames::Ct, float>> floats_;  ///< or this.
  std::optional<std::int16_t> unknown_;
  struct KnownDigest;
  std::shared_ptr<KnownDigest> digest_;  ///< Shared by copies.
};

/// A feature per voxel, on the grid of the volume that it was derived from. NaN: undefined, which
/// every predicate takes as false. Copying copies a pointer; thread-safe to read.
struct FeatureVolume {
  VoxelGrid grid;
  std::shared_ptr<const std::vector<float>> values;
  [[nodiscard]] float at(int i, int j, int k) const { return (*values)[offset_of(grid, i, j, k)]; }
};

/// Least and greatest known value, and the values below which the shares low_share and high_share
/// of the known voxels lie. The two latter are accurate to 1/4096 of the range, and more accurate
/// the closer they are to each other, so one loud voxel does not make them equal. All NaN if no
/// voxel is known.
struct ValueRange {
  double least, greatest, low, high;
  std::size_t known = 0;
};
ValueRange value_range(const ScalarVolume& volume, double low_share, double high_share,
                       int threads);

}  // namespace nav::render::features
