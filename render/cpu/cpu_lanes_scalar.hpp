// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "render/cpu/cpu_march.hpp"

namespace nav::render {
namespace {

/// One lane, for processors without AVX2 and as a check of the vector lanes.
struct Scalar {
  using F = float;
  using I = int;
  using M = bool;
  static constexpr int kLanes = 1;
  struct Lanes {
    I at[kLanes];
    explicit Lanes(I i) : at{i} {}
  };
  static constexpr bool kPacks = false;

  static double root(double x) { return std::sqrt(x); }
  static F set(float x) { return x; }
  static I set_int(int x) { return x; }
  static F load(const float* p) { return *p; }
  static void store(float* p, F x) { *p = x; }
  static F sub(F a, F b) { return a - b; }
  static F div(F a, F b) { return a / b; }
  static F madd(F a, F b, F c) { return a * b + c; }
  static F min(F a, F b) { return a < b ? a : b; }
  static F max(F a, F b) { return a > b ? a : b; }
  static F abs(F a) { return std::fabs(a); }
  static F sqrt(F a) { return std::sqrt(a); }
  static F floor(F a) { return std::floor(a); }
  static F add(F a, F b) { return a + b; }
  static F mul(F a, F b) { return a * b; }
  static I add(I a, I b) { return a + b; }
  static I mul(I a, I b) { return a * b; }
  static I subtract(I a, I b) { return a - b; }
  static I max_int(I a, I b) { return a > b ? a : b; }
  static I shift_right_3(I a) { return a >> 3; }
  static I shift_left_3(I a) { return a * 8; }
  static I shift_right(I a, I by) { return a >> by; }
  static I bits(I a, int kept) { return a & kept; }
  static I mask_int(M m, I a) { return m ? a : 0; }
  static I truncate(F a) { return static_cast<int>(a); }
  static F to_float(I a) { return static_cast<float>(a); }
  static M less(F a, F b) { return a < b; }
  static M not_less(F a, F b) { return a >= b; }
  static M both(M a, M b) { return a && b; }
  static M either(M a, M b) { return a || b; }
  static M exclusive(M a, M b) { return a != b; }
  static M none() { return false; }
  static M all() { return true; }
  static M negate(M a) { return !a; }
  static bool any(M a) { return a; }
  static int count(M a) { return a ? 1 : 0; }
  static F select(M m, F a, F b) { return m ? a : b; }
  static F mask(M m, F a) { return m ? a : 0.0F; }
  static F one_minus_exp(F x) { return -std::expm1(-x); }
  static F log1p(F x) { return std::log1p(x); }
  static F power(F base, float exponent) { return std::pow(base, exponent); }
  static std::int16_t lower_half(std::int32_t pair) { return static_cast<std::int16_t>(pair); }
  static std::int16_t upper_half(std::int32_t pair) {
    return static_cast<std::int16_t>(pair >> 16);
  }
  /// Voxels at `at` and at + 1 of CpuVolume, and those one row, one slice, and both further.
  static void load_cells(const std::int32_t* p, int slice, I at, F (*rows)[2]) {
    for (int z = 0; z < 2; ++z) {
      for (int x = 0; x < 2; ++x) {
        const std::int32_t pair = p[at + z * slice + x];
        rows[2 * z][x] = lower_half(pair);
        rows[2 * z + 1][x] = upper_half(pair);
      }
    }
  }
  /// Trilinear central differences along each axis, over index steps of two.
  static void differences(const std::int32_t* voxels, int row, int slice, I base, const F* w,
                          M /*needed*/, F* g) {
    const int stride[3] = {1, row, slice};
    for (int axis = 0; axis < 3; ++axis) {
      g[axis] = trilinear(voxels, slice, base + stride[axis], w) -
                trilinear(voxels, slice, base - stride[axis], w);
    }
  }
  static F trilinear(const std::int32_t* p, int slice, I at, const F* w) {
    F rows[4][2];
    load_cells(p, slice, at, rows);
    F value[4];
    for (int i = 0; i < 4; ++i) value[i] = madd(w[0], rows[i][1] - rows[i][0], rows[i][0]);
    const F below = madd(w[1], value[1] - value[0], value[0]);
    const F above = madd(w[1], value[3] - value[2], value[2]);
    return madd(w[2], above - below, below);
  }
  static M load_bit(const std::int32_t* words, I at) {
    return (words[at >> 5] >> (at & 31) & 1) != 0;
  }
  static I load_signed_byte(const std::int8_t* p, I at) { return p[at]; }
  static I load_byte(const std::uint8_t* p, I at) { return p[at]; }
  static F load_float(const float* p, I at) { return p[at]; }
  static void load_range(const std::int32_t* p, I at, F& low, F& high) {
    low = lower_half(p[at]);
    high = upper_half(p[at]);
  }
  static void lookup(const TableEntry* table, I at, F w, F* out) {
    for (int i = 0; i < 4; ++i) out[i] = madd(w, table[at].to_next[i], table[at].value[i]);
  }
  struct Integral {
    std::int32_t sum[4];
    F half[4];
  };
  static void integral(const IntegralEntry* table, I at, F w, Integral& out) {
    const IntegralEntry& entry = table[at];
    for (int i = 0; i < 4; ++i) {
      const F there = entry.half[i] + w * entry.bend[i];
      out.sum[i] =
          entry.before[i] + static_cast<std::int32_t>(std::nearbyint(w * (entry.half[i] + there)));
      out.half[i] = there;
    }
  }
  static void change(const Integral& a, const Integral& b, F of_a, F of_b, F* out) {
    for (int i = 0; i < 4; ++i) {
      const auto sums = static_cast<F>(b.sum[i] - a.sum[i]);
      out[i] = madd(of_a, a.half[i], madd(of_b, b.half[i], sums));
    }
  }
};

}  // namespace
}  // namespace nav::render
