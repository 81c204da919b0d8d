// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <immintrin.h>

#include "render/cpu/cpu_lanes_math.hpp"
#include "render/cpu/cpu_march.hpp"

namespace nav::render {
namespace {

/// Eight lanes of AVX2.
struct Avx2 : LaneMath<Avx2> {
  using F = __m256;
  struct I {
    __m256i v;
  };
  struct M {
    __m256 v;
  };
  static constexpr int kLanes = 8;
  static constexpr bool kPacks = false;  ///< Lanes are read one by one, so few lanes cost little.

  static double root(double x) { return _mm_cvtsd_f64(_mm_sqrt_pd(_mm_set1_pd(x))); }
  static F set(float x) { return _mm256_set1_ps(x); }
  static I set_int(int x) { return {_mm256_set1_epi32(x)}; }
  static F load(const float* p) { return _mm256_load_ps(p); }
  static void store(float* p, F x) { _mm256_store_ps(p, x); }
  static F add(F a, F b) { return _mm256_add_ps(a, b); }
  static F sub(F a, F b) { return _mm256_sub_ps(a, b); }
  static F mul(F a, F b) { return _mm256_mul_ps(a, b); }
  static F div(F a, F b) { return _mm256_div_ps(a, b); }
  static F madd(F a, F b, F c) { return _mm256_fmadd_ps(a, b, c); }
  static F min(F a, F b) { return _mm256_min_ps(a, b); }
  static F max(F a, F b) { return _mm256_max_ps(a, b); }
  static F abs(F a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0F), a); }
  static F sqrt(F a) { return _mm256_sqrt_ps(a); }
  static F floor(F a) { return _mm256_floor_ps(a); }
  static I add(I a, I b) { return {_mm256_add_epi32(a.v, b.v)}; }
  static I subtract(I a, I b) { return {_mm256_sub_epi32(a.v, b.v)}; }
  static I mul(I a, I b) { return {_mm256_mullo_epi32(a.v, b.v)}; }
  static I max_int(I a, I b) { return {_mm256_max_epi32(a.v, b.v)}; }
  static I shift_right_3(I a) { return {_mm256_srai_epi32(a.v, 3)}; }
  static I shift_left_3(I a) { return {_mm256_slli_epi32(a.v, 3)}; }
  static I shift_right(I a, I by) { return {_mm256_srlv_epi32(a.v, by.v)}; }
  static I bits(I a, int kept) { return {_mm256_and_si256(a.v, _mm256_set1_epi32(kept))}; }
  static I mask_int(M m, I a) { return {_mm256_and_si256(_mm256_castps_si256(m.v), a.v)}; }
  static I truncate(F a) { return {_mm256_cvttps_epi32(a)}; }
  static F to_float(I a) { return _mm256_cvtepi32_ps(a.v); }
  static M less(F a, F b) { return {_mm256_cmp_ps(a, b, _CMP_LT_OQ)}; }
  static M not_less(F a, F b) { return {_mm256_cmp_ps(a, b, _CMP_GE_OQ)}; }
  static M both(M a, M b) { return {_mm256_and_ps(a.v, b.v)}; }
  static M either(M a, M b) { return {_mm256_or_ps(a.v, b.v)}; }
  static M exclusive(M a, M b) { return {_mm256_xor_ps(a.v, b.v)}; }
  static M none() { return {_mm256_setzero_ps()}; }
  static M all() { return negate(none()); }
  static M negate(M a) { return {_mm256_xor_ps(a.v, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))}; }
  static bool any(M a) { return _mm256_movemask_ps(a.v) != 0; }
  static int count(M a) {
    return __builtin_popcount(static_cast<unsigned>(_mm256_movemask_ps(a.v)));
  }
  static F select(M m, F a, F b) { return _mm256_blendv_ps(b, a, m.v); }
  static F mask(M m, F a) { return _mm256_and_ps(m.v, a); }

  static F minus_product(F a, F b, F c) { return _mm256_fnmadd_ps(a, b, c); }
  static F nearest(F a) {
    return _mm256_round_ps(a, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
  }
  static F two_to(F whole) {
    const __m256i exponent = _mm256_add_epi32(_mm256_cvtps_epi32(whole), _mm256_set1_epi32(127));
    return _mm256_castsi256_ps(_mm256_slli_epi32(exponent, 23));
  }
  static void take_apart(F x, F& mantissa, I& exponent) {
    const __m256i bits = _mm256_castps_si256(x);
    exponent = {_mm256_sub_epi32(_mm256_srli_epi32(bits, 23), _mm256_set1_epi32(126))};
    mantissa = _mm256_castsi256_ps(_mm256_or_si256(
        _mm256_and_si256(bits, _mm256_set1_epi32(0x007fffff)), _mm256_set1_epi32(0x3f000000)));
  }

  static F low_half(__m256i pair) {
    return _mm256_cvtepi32_ps(_mm256_srai_epi32(_mm256_slli_epi32(pair, 16), 16));
  }
  static F high_half(__m256i pair) { return _mm256_cvtepi32_ps(_mm256_srai_epi32(pair, 16)); }

  /// Pairs of rows of CpuVolume: the words at `at` and at + 1, and those one slice further. Loads
  /// lane by lane, because gathers of eight are slower on some processors and not faster on others.
  static void load_cell_words(const std::int32_t* p, int slice, I at, F* words) {
    const Lanes lanes(at);
    const auto of = [&](int lane) {
      const std::int32_t* q = p + lanes.at[lane];
      const __m128i low = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(q));
      return _mm_loadh_pi(_mm_castsi128_ps(low), reinterpret_cast<const __m64*>(q + slice));
    };
    F two[4];
    for (int i = 0; i < 4; ++i) two[i] = _mm256_set_m128(of(i + 4), of(i));
    transpose(two, words);
  }
  /// Voxels at `at` and at + 1 of CpuVolume, and those one row, one slice, and both further.
  static void load_cells(const std::int32_t* p, int slice, I at, F (*rows)[2]) {
    F words[4];
    load_cell_words(p, slice, at, words);
    for (int z = 0; z < 2; ++z) {
      for (int x = 0; x < 2; ++x) {
        rows[2 * z][x] = low_half(_mm256_castps_si256(words[2 * z + x]));
        rows[2 * z + 1][x] = high_half(_mm256_castps_si256(words[2 * z + x]));
      }
    }
  }
  static __m128 low_lanes(F x) { return _mm256_castps256_ps128(x); }
  static __m128 high_lanes(F x) { return _mm256_extractf128_ps(x, 1); }
  static __m128 lerp4(__m128 a, __m128 b, __m128 w) { return _mm_fmadd_ps(w, _mm_sub_ps(b, a), a); }
  static F lerp8(F a, F b, F w) { return madd(w, sub(b, a), a); }

  /// Rows of four voxels: rows[0] from the lower halves of the pairs, rows[1] from the upper
  /// halves. The lower four lanes come from p, the upper four from q.
  static void load_rows(const std::int32_t* p, const std::int32_t* q, F* rows) {
    const __m256i pairs = _mm256_set_m128i(_mm_loadu_si128(reinterpret_cast<const __m128i*>(q)),
                                           _mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
    rows[0] = low_half(pairs);
    rows[1] = high_half(pairs);
  }
  /// For the four voxels around a position along x: the value and the differences along y and z,
  /// interpolated along y and z.
  static void around(const std::int32_t* p, int row, int slice, float y, float z, __m128* out) {
    --p;
    F near[2];  // Rows y - 1 and y; lower half: z, upper half: z + 1.
    F far[2];   // y + 1 and y + 2.
    F ends[2];  // y and y + 1 of z - 1 and z + 2.
    load_rows(p - row, p - row + slice, near);
    load_rows(p + row, p + row + slice, far);
    load_rows(p - slice, p + 2 * slice, ends);
    const F outer = lerp8(ends[0], ends[1], set(y));
    const F value = lerp8(near[1], far[0], set(y));
    const F along_y = lerp8(sub(far[0], near[0]), sub(far[1], near[1]), set(y));
    const __m128 w = _mm_set1_ps(z);
    out[0] = lerp4(low_lanes(value), high_lanes(value), w);
    out[1] = lerp4(low_lanes(along_y), high_lanes(along_y), w);
    out[2] = lerp4(_mm_sub_ps(high_lanes(value), low_lanes(outer)),
                   _mm_sub_ps(high_lanes(outer), low_lanes(value)), w);
  }
  /// Trilinear central differences along each axis, over index steps of two. Works lane by lane, so
  /// that the rows of four voxels of a lane serve all three axes.
  static void differences(const std::int32_t* voxels, int row, int slice, I base, const F* w,
                          M needed, F* g) {
    const Lanes lanes(base);
    alignas(32) float y[8];
    alignas(32) float z[8];
    store(y, w[1]);
    store(z, w[2]);
    __m128 rows[8][3] = {};
    const int bits = _mm256_movemask_ps(needed.v);
    for (int lane = 0; lane < 8; ++lane) {
      if (((bits >> lane) & 1) == 0) continue;
      around(voxels + lanes.at[lane], row, slice, y[lane], z[lane], rows[lane]);
    }
    F x[3][4];
    for (int axis = 0; axis < 3; ++axis) {
      F pair[4];
      for (int i = 0; i < 4; ++i) pair[i] = _mm256_set_m128(rows[i + 4][axis], rows[i][axis]);
      transpose(pair, x[axis]);
    }
    g[0] = lerp8(sub(x[0][2], x[0][0]), sub(x[0][3], x[0][1]), w[0]);
    g[1] = lerp8(x[1][1], x[1][2], w[0]);
    g[2] = lerp8(x[2][1], x[2][2], w[0]);
  }
  /// Bit `at` of an array of words.
  static M load_bit(const std::int32_t* words, I at) {
    const __m256i word = _mm256_i32gather_epi32(words, _mm256_srli_epi32(at.v, 5), 4);
    const __m256i up = _mm256_sub_epi32(_mm256_set1_epi32(31), bits(at, 31).v);
    return {_mm256_castsi256_ps(_mm256_srai_epi32(_mm256_sllv_epi32(word, up), 31))};
  }
  static I load_signed_byte(const std::int8_t* p, I at) {
    const __m256i word = _mm256_i32gather_epi32(reinterpret_cast<const int*>(p), at.v, 1);
    return {_mm256_srai_epi32(_mm256_slli_epi32(word, 24), 24)};
  }
  static I load_byte(const std::uint8_t* p, I at) {
    const __m256i word = _mm256_i32gather_epi32(reinterpret_cast<const int*>(p), at.v, 1);
    return {_mm256_and_si256(word, _mm256_set1_epi32(0xff))};
  }
  static F load_float(const float* p, I at) { return _mm256_i32gather_ps(p, at.v, 4); }
  /// Loads two signed 16-bit numbers.
  static void load_range(const std::int32_t* p, I at, F& low, F& high) {
    const __m256i word = _mm256_i32gather_epi32(p, at.v, 4);
    low = low_half(word);
    high = high_half(word);
  }

  /// Lane i in the lower half and lane i + 4 in the upper half, each four times.
  template <int i>
  static F spread(F x) {
    return _mm256_shuffle_ps(x, x, i * 0x55);
  }
  /// Loads four numbers of each of two lanes.
  static F load_two(const float* low, const float* high) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(low)), _mm_load_ps(high), 1);
  }
  static __m256i load_two(const std::int32_t* low, const std::int32_t* high) {
    return _mm256_castps_si256(
        load_two(reinterpret_cast<const float*>(low), reinterpret_cast<const float*>(high)));
  }
  /// Converts pairs of lanes (i, i + 4) with four numbers each to four numbers of eight lanes.
  static void transpose(const F* pair, F* out) {
    const F t0 = _mm256_unpacklo_ps(pair[0], pair[1]);
    const F t1 = _mm256_unpackhi_ps(pair[0], pair[1]);
    const F t2 = _mm256_unpacklo_ps(pair[2], pair[3]);
    const F t3 = _mm256_unpackhi_ps(pair[2], pair[3]);
    out[0] = _mm256_shuffle_ps(t0, t2, 0x44);
    out[1] = _mm256_shuffle_ps(t0, t2, 0xEE);
    out[2] = _mm256_shuffle_ps(t1, t3, 0x44);
    out[3] = _mm256_shuffle_ps(t1, t3, 0xEE);
  }
  struct Lanes {
    alignas(32) int at[8];
    explicit Lanes(I i) { _mm256_store_si256(reinterpret_cast<__m256i*>(at), i.v); }
  };

  template <int i>
  static F lookup_two(const TableEntry* table, const Lanes& lanes, F w) {
    const TableEntry& low = table[lanes.at[i]];
    const TableEntry& high = table[lanes.at[i + 4]];
    return madd(spread<i>(w), load_two(low.to_next, high.to_next), load_two(low.value, high.value));
  }
  /// Interpolates one entry per lane.
  static void lookup(const TableEntry* table, I at, F w, F* out) {
    const Lanes lanes(at);
    const F pair[4] = {lookup_two<0>(table, lanes, w), lookup_two<1>(table, lanes, w),
                       lookup_two<2>(table, lanes, w), lookup_two<3>(table, lanes, w)};
    transpose(pair, out);
  }

  /// Four integrals and halves of their derivatives, in pairs of lanes as in load_two().
  struct Integral {
    __m256i sum[4];
    F half[4];
  };
  template <int i>
  static void integral_two(const IntegralEntry* table, const Lanes& lanes, F w, Integral& out) {
    const IntegralEntry& low = table[lanes.at[i]];
    const IntegralEntry& high = table[lanes.at[i + 4]];
    const F weight = spread<i>(w);
    const F half = load_two(low.half, high.half);
    const F there = madd(weight, load_two(low.bend, high.bend), half);
    const __m256i part = _mm256_cvtps_epi32(mul(weight, add(half, there)));
    out.sum[i] = _mm256_add_epi32(load_two(low.before, high.before), part);
    out.half[i] = there;
  }
  static void integral(const IntegralEntry* table, I at, F w, Integral& out) {
    const Lanes lanes(at);
    integral_two<0>(table, lanes, w, out);
    integral_two<1>(table, lanes, w, out);
    integral_two<2>(table, lanes, w, out);
    integral_two<3>(table, lanes, w, out);
  }
  template <int i>
  static F change_two(const Integral& a, const Integral& b, F of_a, F of_b) {
    const F sums = _mm256_cvtepi32_ps(_mm256_sub_epi32(b.sum[i], a.sum[i]));
    return madd(spread<i>(of_a), a.half[i], madd(spread<i>(of_b), b.half[i], sums));
  }
  /// Change of the integrals plus of_a and of_b times the halves of their derivatives.
  static void change(const Integral& a, const Integral& b, F of_a, F of_b, F* out) {
    const F pair[4] = {change_two<0>(a, b, of_a, of_b), change_two<1>(a, b, of_a, of_b),
                       change_two<2>(a, b, of_a, of_b), change_two<3>(a, b, of_a, of_b)};
    transpose(pair, out);
  }
};

}  // namespace
}  // namespace nav::render
