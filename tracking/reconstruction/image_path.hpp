// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "tracking/reconstruction/image_area.hpp"

namespace nav::tracking {

/// Fractional bits of positions in the volume. Steps along a row are added, so sums are exact, and
/// the bounds of a row can be computed without visiting its pixels.
inline constexpr int kPositionBits = 32;

/// Position in the volume, voxels, as fixed-point numbers.
using FixedPosition = std::array<std::int64_t, 3>;

/// Positions of the pixels of one image in a volume.
class ImagePath {
 public:
  /// \p shift: added to every coordinate, voxels. Absent when the image lies more than 2^29 voxels
  /// away.
  static std::optional<ImagePath> of(const TrackedImage& image,
                                     const VoxelGridIn<frames::Reference>& grid, double shift);

  /// Position of the first pixel of a row.
  [[nodiscard]] FixedPosition row_start(int row) const;
  /// Step from a column to the next.
  [[nodiscard]] const FixedPosition& step() const { return step_; }
  /// Position of a pixel, voxels, with the shift.
  [[nodiscard]] Eigen::Vector3d at(double column, double row) const {
    return start_ + column * per_column_ + row * per_row_;
  }
  [[nodiscard]] const Eigen::Vector3d& per_row() const { return per_row_; }

 private:
  ImagePath() = default;
  Eigen::Vector3d start_, per_column_, per_row_;
  FixedPosition step_{};
};

/// The columns of [first, past) whose coordinate start + column * step lies in [low, high),
/// exactly. All fixed-point.
struct ColumnSpan {
  int first, past;
};
ColumnSpan columns_within(ColumnSpan columns, std::int64_t start, std::int64_t step,
                          std::int64_t low, std::int64_t high);

}  // namespace nav::tracking
