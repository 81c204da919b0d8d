// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <immintrin.h>

#include "render/cpu/cpu_lanes_math.hpp"
#include "render/cpu/cpu_march.hpp"

namespace nav::render {
namespace {

/// Sixteen lanes of AVX-512. Every lane does the same operations as a lane of Avx2, in the same
/// order, so that both give the same bytes. Voxels: cpu_voxels_avx512.hpp.
struct Avx512 : LaneMath<Avx512> {
  using F = __m512;
  struct I {
    __m512i v;
  };
  struct M {
    __mmask16 v;
  };
  static constexpr int kLanes = 16;

  static double root(double x) { return _mm_cvtsd_f64(_mm_sqrt_pd(_mm_set1_pd(x))); }
  static F set(float x) { return _mm512_set1_ps(x); }
  static I set_int(int x) { return {_mm512_set1_epi32(x)}; }
  static F load(const float* p) { return _mm512_loadu_ps(p); }
  static void store(float* p, F x) { _mm512_storeu_ps(p, x); }
  static F add(F a, F b) { return _mm512_add_ps(a, b); }
  static F sub(F a, F b) { return _mm512_sub_ps(a, b); }
  static F mul(F a, F b) { return _mm512_mul_ps(a, b); }
  static F div(F a, F b) { return _mm512_div_ps(a, b); }
  static F madd(F a, F b, F c) { return _mm512_fmadd_ps(a, b, c); }
  static F min(F a, F b) { return _mm512_min_ps(a, b); }
  static F max(F a, F b) { return _mm512_max_ps(a, b); }
  static F abs(F a) { return _mm512_abs_ps(a); }
  static F sqrt(F a) { return _mm512_sqrt_ps(a); }
  static F floor(F a) { return _mm512_roundscale_ps(a, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC); }
  static I add(I a, I b) { return {_mm512_add_epi32(a.v, b.v)}; }
  static I subtract(I a, I b) { return {_mm512_sub_epi32(a.v, b.v)}; }
  static I mul(I a, I b) { return {_mm512_mullo_epi32(a.v, b.v)}; }
  static I max_int(I a, I b) { return {_mm512_max_epi32(a.v, b.v)}; }
  static I shift_right_3(I a) { return {_mm512_srai_epi32(a.v, 3)}; }
  static I shift_left_3(I a) { return {_mm512_slli_epi32(a.v, 3)}; }
  static I shift_right(I a, I by) { return {_mm512_srlv_epi32(a.v, by.v)}; }
  static I bits(I a, int kept) { return {_mm512_and_si512(a.v, _mm512_set1_epi32(kept))}; }
  static I mask_int(M m, I a) { return {_mm512_maskz_mov_epi32(m.v, a.v)}; }
  static I truncate(F a) { return {_mm512_cvttps_epi32(a)}; }
  static F to_float(I a) { return _mm512_cvtepi32_ps(a.v); }
  static M less(F a, F b) { return {_mm512_cmp_ps_mask(a, b, _CMP_LT_OQ)}; }
  static M not_less(F a, F b) { return {_mm512_cmp_ps_mask(a, b, _CMP_GE_OQ)}; }
  static M both(M a, M b) { return {_kand_mask16(a.v, b.v)}; }
  static M either(M a, M b) { return {_kor_mask16(a.v, b.v)}; }
  static M exclusive(M a, M b) { return {_kxor_mask16(a.v, b.v)}; }
  static M none() { return {0}; }
  static M all() { return {0xffff}; }
  static M negate(M a) { return {_knot_mask16(a.v)}; }
  static bool any(M a) { return a.v != 0; }
  static int count(M a) { return __builtin_popcount(a.v); }
  static F select(M m, F a, F b) { return _mm512_mask_blend_ps(m.v, b, a); }
  static F mask(M m, F a) { return _mm512_maskz_mov_ps(m.v, a); }

  static constexpr bool kPacks = true;
  /// Stores the lanes of a mask side by side. Undefined values follow, up to kLanes in all.
  static void pack(float* to, M m, F x) { _mm512_storeu_ps(to, _mm512_maskz_compress_ps(m.v, x)); }
  /// The inverse of pack(); 0 in the other lanes.
  static F unpack(const float* from, M m) { return _mm512_maskz_expand_ps(m.v, load(from)); }
  static F pick(F x, I lanes) { return _mm512_permutexvar_ps(lanes.v, x); }
  static F lane_numbers() {
    return _mm512_setr_ps(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  }
  static M first_lanes(int count) {
    return {static_cast<__mmask16>(count < kLanes ? (1U << count) - 1 : 0xffffU)};
  }

  static F minus_product(F a, F b, F c) { return _mm512_fnmadd_ps(a, b, c); }
  static F nearest(F a) {
    return _mm512_roundscale_ps(a, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
  }
  static F two_to(F whole) {
    const __m512i exponent = _mm512_add_epi32(_mm512_cvtps_epi32(whole), _mm512_set1_epi32(127));
    return _mm512_castsi512_ps(_mm512_slli_epi32(exponent, 23));
  }
  static void take_apart(F x, F& mantissa, I& exponent) {
    const __m512i bits = _mm512_castps_si512(x);
    exponent = {_mm512_sub_epi32(_mm512_srli_epi32(bits, 23), _mm512_set1_epi32(126))};
    mantissa = _mm512_castsi512_ps(_mm512_or_si512(
        _mm512_and_si512(bits, _mm512_set1_epi32(0x007fffff)), _mm512_set1_epi32(0x3f000000)));
  }

  static F low_half(__m512i pair) {
    return _mm512_cvtepi32_ps(_mm512_srai_epi32(_mm512_slli_epi32(pair, 16), 16));
  }
  static F high_half(__m512i pair) { return _mm512_cvtepi32_ps(_mm512_srai_epi32(pair, 16)); }

  static F lerp(F a, F b, F w) { return madd(w, sub(b, a), a); }

  /// Bit `at` of an array of words.
  static M load_bit(const std::int32_t* words, I at) {
    const __m512i word = _mm512_i32gather_epi32(_mm512_srli_epi32(at.v, 5), words, 4);
    const __m512i place = _mm512_sllv_epi32(_mm512_set1_epi32(1), bits(at, 31).v);
    return {_mm512_test_epi32_mask(word, place)};
  }
  static __m512i load_words(const void* p, I at) {
    return _mm512_i32gather_epi32(at.v, static_cast<const int*>(p), 1);
  }
  static I load_signed_byte(const std::int8_t* p, I at) {
    return {_mm512_srai_epi32(_mm512_slli_epi32(load_words(p, at), 24), 24)};
  }
  static I load_byte(const std::uint8_t* p, I at) { return bits({load_words(p, at)}, 0xff); }
  static F load_float(const float* p, I at) { return _mm512_i32gather_ps(at.v, p, 4); }
  /// Loads two signed 16-bit numbers.
  static void load_range(const std::int32_t* p, I at, F& low, F& high) {
    const __m512i word = _mm512_i32gather_epi32(at.v, p, 4);
    low = low_half(word);
    high = high_half(word);
  }

  /// Lanes i, i + 4, i + 8, i + 12, each four times.
  template <int i>
  static F spread(F x) {
    return _mm512_shuffle_ps(x, x, i * 0x55);
  }
  /// Joins four numbers of each of four lanes.
  __attribute__((always_inline)) static F join(__m128 a, __m128 b, __m128 c, __m128 d) {
    F four = _mm512_castps128_ps512(a);
    four = _mm512_insertf32x4(four, b, 1);
    four = _mm512_insertf32x4(four, c, 2);
    return _mm512_insertf32x4(four, d, 3);
  }
  static F load_four(const float* a, const float* b, const float* c, const float* d) {
    return join(_mm_load_ps(a), _mm_load_ps(b), _mm_load_ps(c), _mm_load_ps(d));
  }
  /// Byte offsets of entries, computed for all lanes at once.
  template <class Entry>
  static I offsets(I at) {
    return {_mm512_mullo_epi32(at.v, _mm512_set1_epi32(sizeof(Entry)))};
  }
  template <class Entry>
  static const Entry* entry(const Entry* table, std::uint32_t offset) {
    return reinterpret_cast<const Entry*>(reinterpret_cast<const char*>(table) + offset);
  }
  struct Lanes {
    alignas(64) std::uint32_t at[kLanes];
    explicit Lanes(I i) { _mm512_store_si512(at, i.v); }
  };
  template <int i, class Entry>
  static F load_four(const Entry* table, const Lanes& lanes, const float (Entry::*member)[4]) {
    const auto of = [&](int lane) { return entry(table, lanes.at[lane])->*member; };
    return load_four(of(i), of(i + 4), of(i + 8), of(i + 12));
  }
  /// Converts groups of lanes (i, i + 4, i + 8, i + 12) with four numbers each to four numbers of
  /// sixteen lanes.
  static void transpose(const F* four, F* out) {
    const F t0 = _mm512_unpacklo_ps(four[0], four[1]);
    const F t1 = _mm512_unpackhi_ps(four[0], four[1]);
    const F t2 = _mm512_unpacklo_ps(four[2], four[3]);
    const F t3 = _mm512_unpackhi_ps(four[2], four[3]);
    out[0] = _mm512_shuffle_ps(t0, t2, 0x44);
    out[1] = _mm512_shuffle_ps(t0, t2, 0xEE);
    out[2] = _mm512_shuffle_ps(t1, t3, 0x44);
    out[3] = _mm512_shuffle_ps(t1, t3, 0xEE);
  }

  template <int i>
  static F lookup_four(const TableEntry* table, const Lanes& lanes, F w) {
    return madd(spread<i>(w), load_four<i>(table, lanes, &TableEntry::to_next),
                load_four<i>(table, lanes, &TableEntry::value));
  }
  /// Interpolates one entry per lane.
  static void lookup(const TableEntry* table, I at, F w, F* out) {
    const Lanes lanes(offsets<TableEntry>(at));
    const F four[4] = {lookup_four<0>(table, lanes, w), lookup_four<1>(table, lanes, w),
                       lookup_four<2>(table, lanes, w), lookup_four<3>(table, lanes, w)};
    transpose(four, out);
  }

  /// Four integrals and halves of their derivatives, in groups of four lanes as in load_four().
  struct Integral {
    __m512i sum[4];
    F half[4];
  };
  template <int i>
  static void integral_four(const IntegralEntry* table, const Lanes& lanes, F w, Integral& out) {
    // Both lie side by side, so that one load fetches them and fewer joins follow.
    static_assert(offsetof(IntegralEntry, half) == 4 * sizeof(float));
    const auto two = [&](int low, int high) {
      const auto of = [&](int lane) {
        return _mm256_load_ps(reinterpret_cast<const float*>(entry(table, lanes.at[lane])->before));
      };
      return _mm512_insertf32x8(_mm512_castps256_ps512(of(low)), of(high), 1);
    };
    const F first = two(i, i + 4);
    const F second = two(i + 8, i + 12);
    const F before = _mm512_shuffle_f32x4(first, second, 0x88);
    const F half = _mm512_shuffle_f32x4(first, second, 0xDD);
    const F weight = spread<i>(w);
    const F there = madd(weight, load_four<i>(table, lanes, &IntegralEntry::bend), half);
    const __m512i part = _mm512_cvtps_epi32(mul(weight, add(half, there)));
    out.sum[i] = _mm512_add_epi32(_mm512_castps_si512(before), part);
    out.half[i] = there;
  }
  static void integral(const IntegralEntry* table, I at, F w, Integral& out) {
    const Lanes lanes(offsets<IntegralEntry>(at));
    integral_four<0>(table, lanes, w, out);
    integral_four<1>(table, lanes, w, out);
    integral_four<2>(table, lanes, w, out);
    integral_four<3>(table, lanes, w, out);
  }
  template <int i>
  static F change_four(const Integral& a, const Integral& b, F of_a, F of_b) {
    const F sums = _mm512_cvtepi32_ps(_mm512_sub_epi32(b.sum[i], a.sum[i]));
    return madd(spread<i>(of_a), a.half[i], madd(spread<i>(of_b), b.half[i], sums));
  }
  /// Change of the integrals plus of_a and of_b times the halves of their derivatives.
  static void change(const Integral& a, const Integral& b, F of_a, F of_b, F* out) {
    const F four[4] = {change_four<0>(a, b, of_a, of_b), change_four<1>(a, b, of_a, of_b),
                       change_four<2>(a, b, of_a, of_b), change_four<3>(a, b, of_a, of_b)};
    transpose(four, out);
  }
};

}  // namespace
}  // namespace nav::render
