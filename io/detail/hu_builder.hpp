// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "io/detail/voxel_sink.hpp"
#include "io/pixel_type.hpp"
#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::io::detail {

/// Collects voxels in the order i, j, k, rounds them to the nearest HU, limits them to [least,
/// 32767] and counts the changes. Padding becomes air.
class HuBuilder final : public VoxelSink {
 public:
  /// Reserves memory for \p voxel_count voxels; the caller has checked that the file can hold them.
  explicit HuBuilder(std::size_t voxel_count = 0, std::int16_t least = kAirHu) : floor_(least) {
    hu_.reserve(voxel_count);
  }

  /// Declares that the file is a CT, whose values are never below air.
  void set_ct() { ct_ = true; }
  void reserve(std::size_t voxel_count) override { hu_.reserve(voxel_count); }
  void append(std::span<const std::byte> samples, PixelType type, const Rescale& rescale) override;
  [[nodiscard]] const std::vector<std::int16_t>& hu() const { return hu_; }
  /// Least span of Hounsfield units if some are not whole: values of a smaller span would keep
  /// fewer than 6 bits when rounded to HU.
  static constexpr double kLeastSpan = 64;
  /// Moves the voxels out.
  [[nodiscard]] std::vector<std::int16_t> take() { return std::move(hu_); }

  /// Reports the counts, and warns when many different values were lost. Rejects voxels that are
  /// not finite, with their number and the first index, and values that rounding would destroy
  /// (some not whole, all within less than kLeastSpan of each other), with their range. \p size:
  /// size of the appended stack, for the index. \p unit: see VolumeReading.
  Result<void> report(const std::string& name, const std::array<int, 3>& size,
                      const std::string& unit, Diagnostics& diagnostics) const;
  [[nodiscard]] Result<StoredVolume> finish(const VoxelGrid& grid, const std::string& name,
                                            const std::string& unit, Diagnostics& diagnostics) &&;

 private:
  template <class T>
  void append_shifted(std::span<const std::byte> samples, std::int32_t by);
  void push(double hu);
  /// Counts a value below the least one.
  void note_below(double hu);
  /// True when the values below the least one are not padding, which has only a few different
  /// values.
  [[nodiscard]] bool lost_values() const;
  std::int16_t floor_;
  bool ct_ = false;
  std::vector<std::int16_t> hu_;
  std::size_t below_ = 0;
  std::vector<double> different_below_;  ///< At most kMostPaddings + 1 of them.
  double least_below_ = kAirHu;
  static constexpr std::size_t kMostPaddings = 16;
  std::size_t above_ = 0;
  std::size_t padded_ = 0;
  std::size_t not_finite_ = 0;
  std::size_t first_not_finite_ = 0;
  bool fractions_ = false;  ///< Some value was not whole.
  double least_ = std::numeric_limits<double>::infinity();
  double greatest_ = -std::numeric_limits<double>::infinity();
};

/// Grid of voxels with centres at affine * (i, j, k, 1), LPS, mm. Rejects axes of zero length and
/// axes that are not orthogonal within 1e-3; smaller deviations are rounding of the text and are
/// removed.
Result<VoxelGrid> grid_from_affine(const std::array<int, 3>& size,
                                   const Eigen::Matrix<double, 3, 4>& ct_from_index,
                                   const std::string& name);

}  // namespace nav::io::detail
