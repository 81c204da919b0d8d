// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/features/volume.hpp"

namespace nav::render::features {

/// Values that filters run over: every voxel has one. Beyond the border the border's value counts
/// (as if mirrored at zero slope). Unknown voxels are extended into from the known ones: layer by
/// layer, each takes the mean of those of its 26 neighbours that have a value already. Voxels
/// further than `layers` from any known one are 0.
struct FilledField {
  std::array<int, 3> size{};
  int stride = 0;             ///< Between rows, a multiple of kLanes.
  std::vector<float> values;  ///< Minus reference.
  double reference = 0;       ///< A known value, so that large offsets cost no digits.
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
/// Holds about 4 bytes per voxel; 6 more while unknown voxels are filled.
FilledField filled_field(const ScalarVolume& volume, int layers, int threads);

/// Which bricks of 8^3 voxels see a range of values wider than a limit within a support.
class ActiveBricks {
 public:
  /// support: voxels on either side along each axis.
  ActiveBricks(const FilledField& field, const std::array<int, 3>& support, double least_range,
               int threads);
  /// False: nothing in row (j, k) is active.
  [[nodiscard]] bool row(int j, int k) const;
  /// Share of the bricks, [0, 1].
  [[nodiscard]] double share() const;

 private:
  std::array<int, 3> size_;
  std::array<int, 3> count_;
  std::vector<std::uint8_t> active_;
  std::vector<std::uint8_t> rows_;  ///< Of bricks, whether any is active.
};

}  // namespace nav::render::features
