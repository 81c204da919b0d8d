// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mfma and called only through cpu_marches().
#include "render/cpu/cpu_lanes_avx2.hpp"
#include "render/cpu/predicate_kernel.hpp"

namespace nav::render {
namespace {

/// Avx2 with the integer logic that predicates need.
struct PredicateAvx2 : Avx2 {
  static I load_int(const std::int32_t* p, I at) {
    const Lanes l(at);
    return {_mm256_setr_epi32(p[l.at[0]], p[l.at[1]], p[l.at[2]], p[l.at[3]], p[l.at[4]],
                              p[l.at[5]], p[l.at[6]], p[l.at[7]])};
  }
  static void store_int(std::int32_t* p, I a) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a.v);
  }
  static M has_bits(I a, I mask) {
    const __m256i none = _mm256_cmpeq_epi32(_mm256_and_si256(a.v, mask.v), _mm256_setzero_si256());
    return negate({_mm256_castsi256_ps(none)});
  }
  static void load_cell_words(const std::int32_t* p, int slice, I at, I* words) {
    F found[4];
    Avx2::load_cell_words(p, slice, at, found);
    for (int i = 0; i < 4; ++i) words[i] = {_mm256_castps_si256(found[i])};
  }
  static F first_of(I word) { return low_half(word.v); }
  static F second_of(I word) { return high_half(word.v); }
  static I pair_weights(F w) {
    const __m256i second = _mm256_cvtps_epi32(mul(w, set(kWhole)));
    const __m256i both = _mm256_sub_epi32(_mm256_slli_epi32(second, 16), second);
    return {_mm256_add_epi32(both, _mm256_set1_epi32(static_cast<int>(kWhole)))};
  }
  static F weigh(I word, I weights) {
    return _mm256_cvtepi32_ps(_mm256_madd_epi16(word.v, weights.v));
  }
  /// a | (m ? bits : 0).
  static I or_where(M m, I bits, I a) {
    return {_mm256_or_si256(a.v, _mm256_and_si256(_mm256_castps_si256(m.v), bits.v))};
  }
  /// Loads the floats at `at` and at + 1.
  static void load_float_pair(const float* p, I at, F& a, F& b) {
    const Lanes lanes(at);
    const auto two = [&](int i) {
      const __m128 first =
          _mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p + lanes.at[i])));
      return _mm_loadh_pi(first, reinterpret_cast<const __m64*>(p + lanes.at[i + 1]));
    };
    const F even = _mm256_set_m128(two(4), two(0));
    const F odd = _mm256_set_m128(two(6), two(2));
    a = _mm256_shuffle_ps(even, odd, 0x88);
    b = _mm256_shuffle_ps(even, odd, 0xDD);
  }
  /// True when all lanes of a mask that is not empty hold the same value.
  static bool same(I a, M mask, std::uint32_t& value) {
    const int lanes = _mm256_movemask_ps(mask.v);
    alignas(32) std::uint32_t values[kLanes];
    _mm256_store_si256(reinterpret_cast<__m256i*>(values), a.v);
    value = values[__builtin_ctz(static_cast<unsigned>(lanes))];
    const __m256i equal = _mm256_cmpeq_epi32(a.v, _mm256_set1_epi32(static_cast<int>(value)));
    return (lanes & ~_mm256_movemask_ps(_mm256_castsi256_ps(equal))) == 0;
  }
  static float least_of(F a) {
    __m128 half = _mm_min_ps(low_lanes(a), high_lanes(a));
    half = _mm_min_ps(half, _mm_movehl_ps(half, half));
    return _mm_cvtss_f32(_mm_min_ss(half, _mm_shuffle_ps(half, half, 1)));
  }
  static float greatest_of(F a) {
    __m128 half = _mm_max_ps(low_lanes(a), high_lanes(a));
    half = _mm_max_ps(half, _mm_movehl_ps(half, half));
    return _mm_cvtss_f32(_mm_max_ss(half, _mm_shuffle_ps(half, half, 1)));
  }
  /// True when any lane of a mask has a value, below 64, whose bit is set in \p values.
  static bool any_among(I a, M m, std::uint64_t values) {
    const __m256i one = _mm256_and_si256(_mm256_castps_si256(m.v), _mm256_set1_epi32(1));
    // Shifts by 32 or more, or by less than 0, give 0.
    const __m256i low = _mm256_sllv_epi32(one, a.v);
    const __m256i high = _mm256_sllv_epi32(one, _mm256_sub_epi32(a.v, _mm256_set1_epi32(32)));
    const auto word = [&](int shift) {
      return _mm256_set1_epi32(static_cast<int>(static_cast<std::uint32_t>(values >> shift)));
    };
    const __m256i found =
        _mm256_or_si256(_mm256_and_si256(low, word(0)), _mm256_and_si256(high, word(32)));
    return _mm256_testz_si256(found, found) == 0;
  }
  /// See PredicateAvx512.
  static void octave(F z, I& octave, F& beyond) {
    const __m256i bits = _mm256_castps_si256(z);
    octave = {_mm256_sub_epi32(_mm256_srli_epi32(bits, 23), _mm256_set1_epi32(119))};
    const __m256i rest = _mm256_and_si256(bits, _mm256_set1_epi32(0x007fffff));
    const __m256i one = _mm256_set1_epi32(0x3f800000);
    beyond = sub(_mm256_castsi256_ps(_mm256_or_si256(rest, one)), set(1.0F));
  }
  /// See PredicateAvx512.
  static I nibble(const std::int32_t* words, I at) {
    const __m256i all = _mm256_load_si256(reinterpret_cast<const __m256i*>(words));
    const __m256i word = _mm256_permutevar8x32_epi32(all, _mm256_srli_epi32(at.v, 3));
    const __m256i shift = _mm256_slli_epi32(bits(at, 7).v, 2);
    return bits({_mm256_srlv_epi32(word, shift)}, 15);
  }
  static constexpr int kEightsAtOnce = 1;  ///< Number of eights that pick() reads by one operation.
  /// Entry of a table of eights of floats, aligned to 32 bytes.
  static F pick(const float* table, int eights, I at) {
    F out = _mm256_permutevar8x32_ps(load(table), at.v);
    const __m256i eighth = _mm256_srli_epi32(at.v, 3);
    for (int e = 1; e < eights; ++e) {
      const F here = _mm256_castsi256_ps(_mm256_cmpeq_epi32(eighth, _mm256_set1_epi32(e)));
      out = _mm256_blendv_ps(out, _mm256_permutevar8x32_ps(load(table + 8 * e), at.v), here);
    }
    return out;
  }
  static void load_appearances(const PredicateAppearance* const* appearances, F* out) {
    F pair[4];
    for (int i = 0; i < 4; ++i) pair[i] = load_two(appearances[i]->tint, appearances[i + 4]->tint);
    transpose(pair, out);
  }
};

}  // namespace

PredicateMarchSet avx2_predicate_marches() { return {predicate_march<PredicateAvx2>}; }

}  // namespace nav::render
