// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "render/predicate_kernel.hpp"

namespace nav::render {
namespace {

/// One lane, for processors without AVX2 and as a check of it.
struct PredicateScalar {
  using F = float;
  using I = int;
  using M = bool;
  static constexpr int kLanes = 1;

  static F set(float x) { return x; }
  static I set_int(int x) { return x; }
  static F load(const float* p) { return *p; }
  static void store(float* p, F x) { *p = x; }
  static F add(F a, F b) { return a + b; }
  static F sub(F a, F b) { return a - b; }
  static F mul(F a, F b) { return a * b; }
  static F div(F a, F b) { return a / b; }
  static F madd(F a, F b, F c) { return a * b + c; }
  static F min(F a, F b) { return a < b ? a : b; }
  static F max(F a, F b) { return a > b ? a : b; }
  static F abs(F a) { return std::fabs(a); }
  static F floor(F a) { return std::floor(a); }
  static I add(I a, I b) { return a + b; }
  static I mul(I a, I b) { return a * b; }
  static I subtract(I a, I b) { return a - b; }
  static I shift_right_3(I a) { return a >> 3; }
  static I shift_left_3(I a) { return a * 8; }
  static I truncate(F a) { return static_cast<int>(a); }
  static F to_float(I a) { return static_cast<float>(a); }
  static M less(F a, F b) { return a < b; }
  static M not_less(F a, F b) { return a >= b; }
  static M both(M a, M b) { return a && b; }
  static M either(M a, M b) { return a || b; }
  static M none() { return false; }
  static M negate(M a) { return !a; }
  static bool any(M a) { return a; }
  static int count(M a) { return a ? 1 : 0; }
  static F select(M m, F a, F b) { return m ? a : b; }
  static F mask(M m, F a) { return m ? a : 0.0F; }
  static F one_minus_exp(F x) { return -std::expm1(-x); }
  static F log1p(F x) { return std::log1p(x); }
  static F log(F x) { return std::log(x); }
  static void load_pair(const std::int16_t* p, I at, F& a, F& b) {
    a = p[at];
    b = p[at + 1];
  }
  static void load_cells(const std::int16_t* p, int row, int slice, I at, F (*pairs)[2]) {
    load_pair(p, at, pairs[0][0], pairs[0][1]);
    load_pair(p + row, at, pairs[1][0], pairs[1][1]);
    load_pair(p + slice, at, pairs[2][0], pairs[2][1]);
    load_pair(p + row + slice, at, pairs[3][0], pairs[3][1]);
  }
  static I load_signed_byte(const std::int8_t* p, I at) { return p[at]; }
  static I load_byte(const std::uint8_t* p, I at) { return p[at]; }
  static F load_float(const float* p, I at) { return p[at]; }
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
  static void load_looks(const PredicateLook* const* looks, F* out) {
    for (int i = 0; i < 3; ++i) out[i] = looks[0]->tint[i];
    out[3] = looks[0]->importance;
  }
};

}  // namespace

PredicateMarchSet portable_predicate_marches() { return {predicate_march<PredicateScalar>}; }

}  // namespace nav::render
