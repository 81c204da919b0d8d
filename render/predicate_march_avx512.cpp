// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compiled for x86-64-v4 and entered only through cpu_marches().
#include "render/cpu_lanes_avx512.hpp"
#include "render/predicate_kernel.hpp"

namespace nav::render {
namespace {

/// With the integer logic that predicates need.
struct PredicateAvx512 : Avx512 {
  static I load_int(const std::int32_t* p, I at) { return {_mm512_i32gather_epi32(at.v, p, 4)}; }
  static void store_int(std::int32_t* p, I a) { _mm512_storeu_si512(p, a.v); }
  static M has_bits(I a, I mask) { return {_mm512_test_epi32_mask(a.v, mask.v)}; }
  /// a | (m ? bits : 0).
  static I or_where(M m, I bits, I a) { return {_mm512_mask_or_epi32(a.v, m.v, a.v, bits.v)}; }
  /// Floats at and at + 1.
  static void load_float_pair(const float* p, I at, F& a, F& b) {
    const auto words = reinterpret_cast<const long long*>(p);
    const __m512i low = _mm512_i32gather_epi64(_mm512_castsi512_si256(at.v), words, 4);
    const __m512i high = _mm512_i32gather_epi64(_mm512_extracti64x4_epi64(at.v, 1), words, 4);
    const __m512i even =
        _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    const __m512i odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
    a = _mm512_castsi512_ps(_mm512_permutex2var_epi32(low, even, high));
    b = _mm512_castsi512_ps(_mm512_permutex2var_epi32(low, odd, high));
  }
  /// Whether all lanes of a mask, of which there are some, hold the same value.
  static bool same(I a, M mask, std::uint32_t& value) {
    alignas(64) std::uint32_t values[kLanes];
    _mm512_store_si512(values, a.v);
    value = values[__builtin_ctz(mask.v)];
    const __m512i one = _mm512_set1_epi32(static_cast<int>(value));
    return _mm512_mask_cmpneq_epi32_mask(mask.v, a.v, one) == 0;
  }
  static float least_of(F a) { return _mm512_reduce_min_ps(a); }
  static float greatest_of(F a) { return _mm512_reduce_max_ps(a); }
  /// Whether some lane of a mask has a value, below 64, whose bit is set.
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
  /// An entry of a table of eights of floats, aligned to 32 bytes.
  static F pick(const float* table, int eights, I at) {
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
  static void load_looks(const PredicateLook* const* looks, F* out) {
    F four[4];
    for (int i = 0; i < 4; ++i) {
      four[i] =
          load_four(looks[i]->tint, looks[i + 4]->tint, looks[i + 8]->tint, looks[i + 12]->tint);
    }
    transpose(four, out);
  }
};

}  // namespace

PredicateMarchSet avx512_predicate_marches() { return {predicate_march<PredicateAvx512>}; }

}  // namespace nav::render
