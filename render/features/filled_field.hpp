// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/features/volume.hpp"

namespace nav::render::features {

/// Input of filters, with a value at every voxel. Beyond the border, the value at the border
/// continues (as if mirrored at zero slope). Unknown voxels are filled layer by layer from the
/// known ones: each takes the mean of those of its 26 neighbours that already have a value. Voxels
/// farther than `layers` from any known voxel are 0.
struct FilledField {
  std::array<int, 3> size{};
  int stride = 0;             ///< Distance between rows, a multiple of kLanes.
  std::vector<float> values;  ///< Values minus the reference.
  double reference = 0;       ///< A known value, subtracted so that large offsets lose no digits.
  bool all_known = true;

  [[nodiscard]] const float* row(int j, int k) const {
    return values.data() + (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) +
                            static_cast<std::size_t>(j)) *
                               static_cast<std::size_t>(stride);
  }
  [[nodiscard]] float* row(int j, int k) {
    return const_cast<float*>(static_cast<const FilledField*>(this)->row(j, k));
  }
};
/// Takes about 4 bytes per voxel, and 6 more while unknown voxels are filled.
FilledField filled_field(const ScalarVolume& volume, int layers, int threads);

/// Bricks of 8^3 voxels in which the values vary by more than a limit within a support around them.
class ActiveBricks {
 public:
  /// \p support: number of voxels on either side along each axis.
  ActiveBricks(const FilledField& field, const std::array<int, 3>& support, double least_range,
               int threads);
  /// False when no brick in row (j, k) is active.
  [[nodiscard]] bool row(int j, int k) const;
  /// Share of active bricks, [0, 1].
  [[nodiscard]] double share() const;

 private:
  std::array<int, 3> size_;
  std::array<int, 3> count_;
  std::vector<std::uint8_t> active_;
  std::vector<std::uint8_t> rows_;  ///< For each row of bricks, 1 if any brick is active.
};

}  // namespace nav::render::features
