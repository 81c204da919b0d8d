// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_volume.hpp"

#include <algorithm>
#include <limits>

#include "render/parallel.hpp"

namespace nav::render {
namespace {

constexpr int kBelow = 1;  // Repeated border voxels below 0.
constexpr int kAbove = 2;  // And above n - 1.
constexpr int kBorder = kBelow + kAbove;
constexpr std::size_t kTail = 4;  // The last fetch reads 8 bytes.

std::size_t size_of(int n) { return static_cast<std::size_t>(n); }

}  // namespace

bool CpuVolume::fits(const VoxelGrid& grid) {
  double voxels = 1;
  for (const int n : grid.size) voxels *= n + kBorder;
  return voxels < static_cast<double>(std::numeric_limits<std::int32_t>::max());
}

CpuVolume::CpuVolume(const Volume& ct, int threads) {
  const auto& size = ct.grid().size;
  row_stride_ = size[0] + kBorder;
  slice_stride_ = row_stride_ * (size[1] + kBorder);
  origin_ = size_of(slice_stride_ + row_stride_ + 1) * kBelow;
  copy_voxels(ct, threads);
}

void CpuVolume::copy_voxels(const Volume& ct, int threads) {
  const auto& size = ct.grid().size;
  const std::span<const std::int16_t> hu = ct.hu();
  voxels_.resize(size_of(slice_stride_) * size_of(size[2] + kBorder) + kTail);
  std::vector<std::int16_t> low(size_of(size[2] + kBorder), hu[0]);
  std::vector<std::int16_t> high = low;
  for_each_index(size[2] + kBorder, threads, [&](int padded_k) {
    const int k = std::clamp(padded_k - kBelow, 0, size[2] - 1);
    for (int padded_j = 0; padded_j < size[1] + kBorder; ++padded_j) {
      const int j = std::clamp(padded_j - kBelow, 0, size[1] - 1);
      const std::int16_t* from =
          hu.data() + (size_of(k) * size_of(size[1]) + size_of(j)) * size_of(size[0]);
      std::int16_t* to = voxels_.data() + size_of(padded_k) * size_of(slice_stride_) +
                         size_of(padded_j) * size_of(row_stride_);
      // Plain minima, which the compiler turns into vector instructions.
      std::int16_t least = low[size_of(padded_k)];
      std::int16_t most = high[size_of(padded_k)];
      for (int i = 0; i < size[0]; ++i) {
        least = std::min(least, from[i]);
        most = std::max(most, from[i]);
      }
      low[size_of(padded_k)] = least;
      high[size_of(padded_k)] = most;
      std::fill_n(to, kBelow, from[0]);
      std::copy_n(from, size[0], to + kBelow);
      std::fill_n(to + kBelow + size[0], kAbove, from[size[0] - 1]);
    }
  });
  low_hu_ = *std::min_element(low.begin(), low.end());
  high_hu_ = *std::max_element(high.begin(), high.end());
}

}  // namespace nav::render
