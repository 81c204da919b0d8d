// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>

#include "render/cpu/cpu_lanes_scalar.hpp"
#include "render/cpu/predicate_kernel.hpp"

namespace nav::render {
namespace {

/// Scalar with the other operations that predicates need.
struct PredicateScalar : Scalar {
  static F log(F x) { return std::log(x); }
  /// See Avx2::load_cell_words().
  static void load_cell_words(const std::int32_t* p, int slice, I at, I* words) {
    for (int i = 0; i < 4; ++i) words[i] = p[at + (i >> 1) * slice + (i & 1)];
  }
  static F first_of(I word) { return lower_half(word); }
  static F second_of(I word) { return upper_half(word); }
  static I pair_weights(F w) { return static_cast<I>(std::lrint(w * kWhole)); }
  static F weigh(I word, I second) {
    return static_cast<F>(lower_half(word) * (static_cast<I>(kWhole) - second) +
                          upper_half(word) * second);
  }
  static I load_int(const std::int32_t* p, I at) { return p[at]; }
  static void load_float_pair(const float* p, I at, F& a, F& b) {
    a = p[at];
    b = p[at + 1];
  }
  static bool same(I a, M, std::uint32_t& value) {
    value = static_cast<std::uint32_t>(a);
    return true;
  }
  static float least_of(F a) { return a; }
  static float greatest_of(F a) { return a; }
  static void store_int(std::int32_t* p, I a) { *p = a; }
  static M has_bits(I a, I mask) { return (a & mask) != 0; }
  static I or_where(M m, I bits, I a) { return m ? a | bits : a; }
  static bool any_among(I a, M m, std::uint64_t values) { return m && (values >> a & 1U) != 0; }
  /// See PredicateAvx512. A value below 2^-8 also gives a valid octave.
  static void octave(F z, I& octave, F& beyond) {
    z = std::max(z, 1.0F / 256);
    std::uint32_t bits = 0;
    std::memcpy(&bits, &z, sizeof bits);
    octave = static_cast<I>(bits >> 23) - 119;
    bits = (bits & 0x007fffffU) | 0x3f800000U;
    std::memcpy(&beyond, &bits, sizeof bits);
    beyond -= 1;
  }
  static I nibble(const std::int32_t* words, I at) {
    return static_cast<I>(static_cast<std::uint32_t>(words[at / 8]) >> (4 * (at % 8)) & 15U);
  }
  static constexpr int kEightsAtOnce = 4;
  static F pick(const float* table, int /*eights*/, I at) { return table[at]; }
  static void load_appearances(const PredicateAppearance* const* appearances, F* out) {
    for (int i = 0; i < 3; ++i) out[i] = appearances[0]->tint[i];
    out[3] = appearances[0]->importance;
  }
};

}  // namespace

PredicateMarchSet portable_predicate_marches() { return {predicate_march<PredicateScalar>}; }

}  // namespace nav::render
