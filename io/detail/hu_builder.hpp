// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/pixel_type.hpp"
#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::io::detail {

/// How stored numbers become Hounsfield units: HU = slope * stored + intercept.
struct Rescale {
  double slope = 1;
  double intercept = 0;
  std::optional<std::pair<double, double>> padding;  ///< Stored values in [first, second] are air.
};

/// Collects voxels in order of i, j, k, rounds to the nearest HU, keeps within [-1024, 32767] and
/// counts what it changed.
class HuBuilder {
 public:
  /// Reserves room; the caller has checked that the file can hold that many.
  explicit HuBuilder(std::size_t voxel_count) { hu_.reserve(voxel_count); }

  /// Samples in native byte order.
  void append(std::span<const std::byte> samples, PixelType type, const Rescale& rescale);
  [[nodiscard]] const std::vector<std::int16_t>& hu() const { return hu_; }
  /// Moves the voxels out.
  [[nodiscard]] std::vector<std::int16_t> take() { return std::move(hu_); }

  /// Says what was counted; refuses voxels that were not finite by number and first index. size:
  /// of the appended stack, to name the index.
  Result<void> report(const std::string& name, const std::array<int, 3>& size,
                      Diagnostics& diagnostics) const;
  [[nodiscard]] Result<Volume> finish(const VoxelGrid& grid, const std::string& name,
                                      Diagnostics& diagnostics) &&;

 private:
  template <class T>
  void append_as(std::span<const std::byte> samples, const Rescale& rescale);
  template <class T>
  void append_shifted(std::span<const std::byte> samples, std::int32_t by);
  void push(double hu);
  std::vector<std::int16_t> hu_;
  std::size_t below_ = 0;
  std::size_t above_ = 0;
  std::size_t padded_ = 0;
  std::size_t not_finite_ = 0;
  std::size_t first_not_finite_ = 0;
};

/// Grid of voxels whose centres lie at affine * (i, j, k, 1), LPS, mm. Refuses axes of no length or
/// not orthogonal within 1e-3; removes the rounding of text below that.
Result<VoxelGrid> grid_from_affine(const std::array<int, 3>& size,
                                   const Eigen::Matrix<double, 3, 4>& ct_from_index,
                                   const std::string& name);

}  // namespace nav::io::detail
