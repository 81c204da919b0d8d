// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_lanes_avx512.hpp"

/// Loads of the voxels of sixteen lanes from CpuVolume.
namespace nav::render {
namespace {

/// Loads lane by lane, then joins and transposes: gathers are slower on many processors.
class VoxelsByLane {
  using F = Avx512::F;

 public:
  explicit VoxelsByLane(Avx512::I at) : lanes_(at) {}

  /// Pairs of rows at `at` and at + 1, and those one distance further.
  __attribute__((always_inline)) void cell(const std::int32_t* p, int distance, F* words) const {
    const std::int32_t* next = p + distance;
    const auto of = [&](int lane) __attribute__((always_inline)) {
      const auto* near = reinterpret_cast<const __m128i*>(p + lanes_.at[lane]);
      const auto* far = reinterpret_cast<const __m64*>(next + lanes_.at[lane]);
      return _mm_loadh_pi(_mm_castsi128_ps(_mm_loadl_epi64(near)), far);
    };
    transpose(of, words);
  }
  /// Pairs of rows from `at` to at + 3.
  __attribute__((always_inline)) void row(const std::int32_t* p, F* words) const {
    const auto of = [&](int lane) __attribute__((always_inline)) {
      return _mm_loadu_ps(reinterpret_cast<const float*>(p + lanes_.at[lane]));
    };
    transpose(of, words);
  }

 private:
  /// Transposes four words of each lane, which of(lane) loads.
  template <class OfLane>
  __attribute__((always_inline)) static void transpose(const OfLane& of, F* words) {
    const F four[4] = {
        Avx512::join(of(0), of(4), of(8), of(12)), Avx512::join(of(1), of(5), of(9), of(13)),
        Avx512::join(of(2), of(6), of(10), of(14)), Avx512::join(of(3), of(7), of(11), of(15))};
    Avx512::transpose(four, words);
  }

  Avx512::Lanes lanes_;
};

/// Avx512 with loads of voxels.
struct SamplingAvx512 : Avx512 {
  /// Voxels at `at` and at + 1 of CpuVolume, and those one row, one slice, and both further.
  __attribute__((always_inline)) static void load_cells(const std::int32_t* p, int slice, I at,
                                                        F (*rows)[2]) {
    F words[4];
    VoxelsByLane(at).cell(p, slice, words);
    for (int z = 0; z < 2; ++z) {
      for (int x = 0; x < 2; ++x) {
        rows[2 * z][x] = low_half(_mm512_castps_si512(words[2 * z + x]));
        rows[2 * z + 1][x] = high_half(_mm512_castps_si512(words[2 * z + x]));
      }
    }
  }

  /// Trilinear central differences along each axis, over index steps of two. Computed for all
  /// lanes, needed or not.
  static void differences(const std::int32_t* voxels, int row, int slice, I base, const F* w,
                          M /*needed*/, F* g) {
    const VoxelsByLane from(base);
    F words[4];
    F ends[4][2];  // Rows of the cell at x and x + 1: in the slice before and in the slice after.
    from.cell(voxels - slice, 3 * slice, words);
    halves(words, ends);
    F value[2][4];    // Per slice z, z + 1: values at x - 1 to x + 2, interpolated along y.
    F along_y[2][2];  // At x and x + 1: differences along y.
    F outer[2][2];    // Values at x and x + 1 in slices z - 1 and z + 2.
    for (int z = 0; z < 2; ++z) {
      F near[4][2];  // At x - 1 to x + 2: rows y - 1 and y.
      F far[4][2];   // Rows y + 1 and y + 2.
      from.row(voxels - 1 + z * slice - row, words);
      halves(words, near);
      from.row(voxels - 1 + z * slice + row, words);
      halves(words, far);
      for (int x = 0; x < 4; ++x) value[z][x] = lerp(near[x][1], far[x][0], w[1]);
      for (int x = 0; x < 2; ++x) {
        const F* before = near[x + 1];
        const F* after = far[x + 1];
        along_y[z][x] = lerp(sub(after[0], before[0]), sub(after[1], before[1]), w[1]);
        outer[z][x] = lerp(ends[2 * z + x][0], ends[2 * z + x][1], w[1]);
      }
    }
    F row_of[4];
    for (int x = 0; x < 4; ++x) row_of[x] = lerp(value[0][x], value[1][x], w[2]);
    F y[2];
    F z[2];
    for (int x = 0; x < 2; ++x) {
      y[x] = lerp(along_y[0][x], along_y[1][x], w[2]);
      z[x] = lerp(sub(value[1][x + 1], outer[0][x]), sub(outer[1][x], value[0][x + 1]), w[2]);
    }
    g[0] = lerp(sub(row_of[2], row_of[0]), sub(row_of[3], row_of[1]), w[0]);
    g[1] = lerp(y[0], y[1], w[0]);
    g[2] = lerp(z[0], z[1], w[0]);
  }

 private:
  __attribute__((always_inline)) static void halves(const F* words, F (*pairs)[2]) {
    for (int i = 0; i < 4; ++i) {
      pairs[i][0] = low_half(_mm512_castps_si512(words[i]));
      pairs[i][1] = high_half(_mm512_castps_si512(words[i]));
    }
  }
};

}  // namespace
}  // namespace nav::render
