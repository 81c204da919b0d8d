// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_volume.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "nav/index.hpp"
#include "render/parallel.hpp"

namespace nav::render {
namespace {

constexpr int kBelow = 1;  // Number of repeated border voxels below 0.
constexpr int kAbove = 2;  // Number of repeated border voxels above n - 1.
constexpr int kBorder = kBelow + kAbove;
constexpr std::size_t kFetchTail = 4;  // The last load reads 16 bytes.

/// Least and greatest value.
std::pair<std::int16_t, std::int16_t> range_of(std::span<const std::int16_t> hu) {
  // Plain minima and maxima, which the compiler converts to vector instructions; minmax_element
  // branches.
  std::int16_t low = hu[0];
  std::int16_t high = hu[0];
  for (const std::int16_t v : hu) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  return {low, high};
}

std::int32_t pair_of(std::int16_t lower, std::int16_t upper) {
  return static_cast<std::int32_t>(static_cast<std::uint16_t>(lower) |
                                   static_cast<std::uint32_t>(static_cast<std::uint16_t>(upper))
                                       << 16U);
}

}  // namespace

bool CpuVolume::fits(const VoxelGrid& grid) {
  double voxels = 1;
  for (const int n : grid.size) voxels *= n + kBorder;
  return voxels < static_cast<double>(std::numeric_limits<std::int32_t>::max());
}

CpuVolume::CpuVolume(const StoredVolume& ct, int threads) {
  const auto& size = ct.grid().size;
  row_stride_ = size[0] + kBorder;
  slice_stride_ = row_stride_ * (size[1] + kBorder);
  origin_ = as_size(slice_stride_ + row_stride_ + 1) * kBelow;
  copy_voxels(ct, threads);
}

void CpuVolume::copy_voxels(const StoredVolume& ct, int threads) {
  const auto& size = ct.grid().size;
  voxels_ =
      ZeroedArray<std::int32_t>(as_size(slice_stride_) * as_size(size[2] + kBorder) + kFetchTail);
  std::vector<std::int16_t> low(as_size(size[2]));
  std::vector<std::int16_t> high(as_size(size[2]));
  for_each_index(size[2] + kBorder, threads, [&](int padded_k) {
    copy_slice(ct, padded_k);
    const int k = padded_k - kBelow;
    if (k < 0 || k >= size[2]) return;
    const std::size_t slice = as_size(size[0]) * as_size(size[1]);
    std::tie(low[as_size(k)], high[as_size(k)]) =
        range_of(ct.values().subspan(as_size(k) * slice, slice));
  });
  low_hu_ = *std::min_element(low.begin(), low.end());
  high_hu_ = *std::max_element(high.begin(), high.end());
}

void CpuVolume::copy_slice(const StoredVolume& ct, int padded_k) {
  const auto& size = ct.grid().size;
  const int k = std::clamp(padded_k - kBelow, 0, size[2] - 1);
  const auto row_of = [&](int padded_j) {
    const int j = std::clamp(padded_j - kBelow, 0, size[1] - 1);
    return ct.values().data() + (as_size(k) * as_size(size[1]) + as_size(j)) * as_size(size[0]);
  };
  for (int padded_j = 0; padded_j < size[1] + kBorder; ++padded_j) {
    const std::int16_t* row = row_of(padded_j);
    const std::int16_t* next = row_of(padded_j + 1);
    std::int32_t* to = voxels_.data() + as_size(padded_k) * as_size(slice_stride_) +
                       as_size(padded_j) * as_size(row_stride_);
    std::fill_n(to, kBelow, pair_of(row[0], next[0]));
    std::transform(row, row + size[0], next, to + kBelow, pair_of);
    const std::int32_t last = pair_of(row[size[0] - 1], next[size[0] - 1]);
    std::fill_n(to + kBelow + size[0], kAbove, last);
  }
}

}  // namespace nav::render
