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

/// Collects voxels in order of i, j, k, rounds to the nearest HU, keeps within [least, 32767] and
/// counts what it changed. Padding is air.
class HuBuilder final : public VoxelSink {
 public:
  /// Reserves room; the caller has checked that the file can hold that many.
  explicit HuBuilder(std::size_t voxel_count = 0, std::int16_t least = kAirHu) : floor_(least) {
    hu_.reserve(voxel_count);
  }

  /// The file says that it is a CT: what lies below air is none of its values.
  void set_ct() { ct_ = true; }
  void reserve(std::size_t voxel_count) override { hu_.reserve(voxel_count); }
  void append(std::span<const std::byte> samples, PixelType type, const Rescale& rescale) override;
  [[nodiscard]] const std::vector<std::int16_t>& hu() const { return hu_; }
  /// Values that span less are no Hounsfield units where some are not whole: rounding to HU leaves
  /// them fewer than 6 bits.
  static constexpr double kLeastSpan = 64;
  /// Moves the voxels out.
  [[nodiscard]] std::vector<std::int16_t> take() { return std::move(hu_); }

  /// Says what was counted, and warns where many different values were lost; refuses voxels that
  /// were not finite by number and first index, and values that rounding would destroy: some not
  /// whole, all within less than kLeastSpan of each other, by their range. size: of the appended
  /// stack, to name the index; unit: as CtOptions has it.
  Result<void> report(const std::string& name, const std::array<int, 3>& size,
                      const std::string& unit, Diagnostics& diagnostics) const;
  [[nodiscard]] Result<Volume> finish(const VoxelGrid& grid, const std::string& name,
                                      const std::string& unit, Diagnostics& diagnostics) &&;

 private:
  template <class T>
  void append_shifted(std::span<const std::byte> samples, std::int32_t by);
  void push(double hu);
  /// A value below the least one.
  void note_below(double hu);
  /// Values below the least one are no padding, which has a few values of its own.
  [[nodiscard]] bool lost_values() const;
  std::int16_t floor_;
  bool ct_ = false;
  std::vector<std::int16_t> hu_;
  std::size_t below_ = 0;
  std::vector<double> different_below_;  ///< Up to kMostPaddings + 1 of them.
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

/// Grid of voxels whose centres lie at affine * (i, j, k, 1), LPS, mm. Refuses axes of no length or
/// not orthogonal within 1e-3; removes the rounding of text below that.
Result<VoxelGrid> grid_from_affine(const std::array<int, 3>& size,
                                   const Eigen::Matrix<double, 3, 4>& ct_from_index,
                                   const std::string& name);

}  // namespace nav::io::detail
