// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_voxels_avx512.hpp"
#include "render/cpu/predicate_kernel.hpp"

namespace nav::render {
namespace {

/// SamplingAvx512 with the operations that predicate_kernel.hpp needs.
struct PredicateAvx512 : SamplingAvx512 {
  static I load_int(const std::int32_t* p, I at) { return {_mm512_i32gather_epi32(at.v, p, 4)}; }
  static void store_int(std::int32_t* p, I a) { _mm512_storeu_si512(p, a.v); }
  static M has_bits(I a, I mask) { return {_mm512_test_epi32_mask(a.v, mask.v)}; }
  static F first_of(I word) { return low_half(word.v); }
  static F second_of(I word) { return high_half(word.v); }
  /// Weights of both voxels of a pair, in units of 1 / kWhole.
  static I pair_weights(F w) {
    const __m512i second = _mm512_cvtps_epi32(mul(w, set(kWhole)));
    const __m512i both = _mm512_sub_epi32(_mm512_slli_epi32(second, 16), second);
    return {_mm512_add_epi32(both, _mm512_set1_epi32(static_cast<int>(kWhole)))};
  }
  static F weigh(I word, I weights) {
    return _mm512_cvtepi32_ps(_mm512_madd_epi16(word.v, weights.v));
  }
  /// a | (m ? bits : 0).
  static I or_where(M m, I bits, I a) { return {_mm512_mask_or_epi32(a.v, m.v, a.v, bits.v)}; }
  /// Loads pairs of floats for lanes i, i + 1, i + 4, i + 5, …, i + 13.
  template <int i>
  static F two_pairs(const float* p, const Lanes& lanes) {
    const auto of = [&](int lane) {
      const auto pair = [&](int l) { return reinterpret_cast<const __m64*>(p + lanes.at[l]); };
      return _mm_loadh_pi(_mm_loadl_pi(_mm_setzero_ps(), pair(lane)), pair(lane + 1));
    };
    return join(of(i), of(i + 4), of(i + 8), of(i + 12));
  }
  /// Loads the floats at `at` and at + 1.
  static void load_float_pair(const float* p, I at, F& a, F& b) {
    const Lanes lanes(at);
    const F first = two_pairs<0>(p, lanes);
    const F second = two_pairs<2>(p, lanes);
    a = _mm512_shuffle_ps(first, second, 0x88);
    b = _mm512_shuffle_ps(first, second, 0xDD);
  }
  /// True when all lanes of a mask that is not empty hold the same value.
  static bool same(I a, M mask, std::uint32_t& value) {
    alignas(64) std::uint32_t values[kLanes];
    _mm512_store_si512(values, a.v);
    value = values[__builtin_ctz(mask.v)];
    const __m512i one = _mm512_set1_epi32(static_cast<int>(value));
    return _mm512_mask_cmpneq_epi32_mask(mask.v, a.v, one) == 0;
  }
  static float least_of(F a) { return _mm512_reduce_min_ps(a); }
  static float greatest_of(F a) { return _mm512_reduce_max_ps(a); }
  /// True when any lane of a mask has a value, below 64, whose bit is set in \p values.
  static bool any_among(I a, M m, std::uint64_t values) {
    const __m512i one = _mm512_set1_epi64(1);
    const __m512i set = _mm512_set1_epi64(static_cast<long long>(values));
    const auto half = [&](__m256i at, unsigned lanes) {
      const __m512i bit = _mm512_sllv_epi64(one, _mm512_cvtepu32_epi64(at));
      return _mm512_mask_test_epi64_mask(static_cast<__mmask8>(lanes), bit, set);
    };
    return (half(_mm512_castsi512_si256(a.v), m.v & 0xFFU) |
            half(_mm512_extracti64x4_epi64(a.v, 1), m.v >> 8)) != 0;
  }
  /// For z in [2^-8, 1): the number of its octave, counted from 2^-8, and the fraction by which the
  /// mantissa lies beyond the begin of the octave.
  static void octave(F z, I& octave, F& beyond) {
    const __m512i bits = _mm512_castps_si512(z);
    octave = {_mm512_sub_epi32(_mm512_srli_epi32(bits, 23), _mm512_set1_epi32(119))};
    const __m512i rest = _mm512_and_si512(bits, _mm512_set1_epi32(0x007fffff));
    const __m512i one = _mm512_set1_epi32(0x3f800000);
    beyond = sub(_mm512_castsi512_ps(_mm512_or_si512(rest, one)), set(1.0F));
  }
  /// Reads four bits of eight words, aligned to 32 bytes: from bit 4 (at mod 8) on of word at / 8.
  static I nibble(const std::int32_t* words, I at) {
    const __m256i eight = _mm256_load_si256(reinterpret_cast<const __m256i*>(words));
    const __m512i all = _mm512_broadcast_i32x8(eight);
    const __m512i word = _mm512_permutexvar_epi32(_mm512_srli_epi32(at.v, 3), all);
    const __m512i shift = _mm512_slli_epi32(bits(at, 7).v, 2);
    return bits({_mm512_srlv_epi32(word, shift)}, 15);
  }
  static constexpr int kEightsAtOnce = 4;  ///< Number of eights that pick() reads by one operation.
  /// Entry of a table of eights of floats, aligned to 32 bytes.
  static F pick(const float* table, int eights, I at) {
    if (eights == 4) return _mm512_permutex2var_ps(load(table), at.v, load(table + 16));
    const F first = _mm512_broadcast_f32x8(_mm256_load_ps(table));
    if (eights == 1) return _mm512_permutexvar_ps(at.v, first);
    F out = _mm512_permutexvar_ps(at.v, load(table));
    const __m512i sixteenth = _mm512_srli_epi32(at.v, 4);
    for (int e = 1; 2 * e < eights; ++e) {
      const __mmask16 here = _mm512_cmpeq_epi32_mask(sixteenth, _mm512_set1_epi32(e));
      out = _mm512_mask_permutexvar_ps(out, here, at.v, load(table + 16 * e));
    }
    return out;
  }
  static void load_appearances(const PredicateAppearance* const* appearances, F* out) {
    F four[4];
    for (int i = 0; i < 4; ++i) {
      four[i] = load_four(appearances[i]->tint, appearances[i + 4]->tint, appearances[i + 8]->tint,
                          appearances[i + 12]->tint);
    }
    transpose(four, out);
  }
  __attribute__((always_inline)) static void load_cell_words(const std::int32_t* p, int slice, I at,
                                                             I* words) {
    F found[4];
    VoxelsByLane(at).cell(p, slice, found);
    for (int i = 0; i < 4; ++i) words[i] = {_mm512_castps_si512(found[i])};
  }
};

}  // namespace
}  // namespace nav::render
