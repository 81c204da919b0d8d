// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav::render {

/// Exponentials and logarithms of vector lanes V. They are the same operations for any number of
/// lanes, and V inherits them. V supplies the arithmetic (cpu_kernel.hpp) and also nearest()
/// (rounds to integers), minus_product() (c - a · b), two_to() (integer powers of 2) and
/// take_apart() (x = m · 2^e, m in [0.5, 1)). Include only where a V of an unnamed namespace is
/// defined.
template <class V>
struct LaneMath {
  /// e^r - 1 for |r| <= ln 2 / 2: Taylor series.
  template <class F>
  static F small_exp(F r) {
    F p = V::madd(r, V::set(1.0F / 5040), V::set(1.0F / 720));
    p = V::madd(p, r, V::set(1.0F / 120));
    p = V::madd(p, r, V::set(1.0F / 24));
    p = V::madd(p, r, V::set(1.0F / 6));
    p = V::madd(p, r, V::set(0.5F));
    return V::madd(V::mul(p, r), r, r);
  }
  /// e^y = scale · (1 + part), |part| < 0.42, y in [-87, 0]: y = n ln 2 + r.
  template <class F>
  static void split_exp(F y, F& scale, F& part) {
    const F clamped = V::max(y, V::set(-87.0F));
    const F n = V::nearest(V::mul(clamped, V::set(1.44269504F)));
    F r = V::minus_product(n, V::set(0.693359375F), clamped);
    r = V::minus_product(n, V::set(-2.12194440e-4F), r);
    part = small_exp(r);
    scale = V::two_to(n);
  }
  /// 1 - e^-x without cancellation for small x >= 0.
  template <class F>
  static F one_minus_exp(F x) {
    const F y = V::sub(V::set(0.0F), x);
    // Then n is 0 in all lanes, and this gives the same result.
    if (!V::any(V::less(V::set(0.34F), x))) return V::sub(V::set(0.0F), small_exp(y));
    F scale;
    F part;
    split_exp(y, scale, part);
    return V::minus_product(scale, part, V::sub(V::set(1.0F), scale));
  }
  /// Natural logarithm of x >= 1e-38, after Cephes logf.
  template <class F>
  static F log(F x) {
    F m;
    typename V::I e;
    V::take_apart(x, m, e);
    const auto small = V::less(m, V::set(0.707106781F));
    e = V::subtract(e, V::mask_int(small, V::set_int(1)));
    m = V::sub(V::add(m, V::mask(small, m)), V::set(1.0F));
    constexpr float kLog[9] = {7.0376836292e-2F,  -1.1514610310e-1F, 1.1676998740e-1F,
                               -1.2420140846e-1F, 1.4249322787e-1F,  -1.6668057665e-1F,
                               2.0000714765e-1F,  -2.4999993993e-1F, 3.3333331174e-1F};
    F p = V::set(kLog[0]);
    for (int i = 1; i < 9; ++i) p = V::madd(p, m, V::set(kLog[i]));
    const F n = V::to_float(e);
    const F square = V::mul(m, m);
    F log = V::mul(V::mul(p, m), square);
    log = V::madd(n, V::set(-2.12194440e-4F), log);
    log = V::minus_product(V::set(0.5F), square, log);
    log = V::add(log, m);
    return V::madd(n, V::set(0.693359375F), log);
  }
  /// log(1 + x) for x in (-1, 0]; the rounding error of 1 + x is divided out.
  template <class F>
  static F log1p(F x) {
    const F nothing = V::set(0.0F);
    const F u = V::add(V::set(1.0F), x);
    const F d = V::sub(u, V::set(1.0F));
    const auto tiny = V::both(V::not_less(d, nothing), V::not_less(nothing, d));
    const F exact = V::mul(log(u), V::div(x, V::select(tiny, V::set(1.0F), d)));
    return V::select(tiny, x, exact);
  }
  /// base^exponent for base in [0, 1], exponent >= 0.
  template <class F>
  static F power(F base, float exponent) {
    const F x = V::max(base, V::set(1.17549435e-38F));
    F scale;
    F part;
    split_exp(V::min(V::mul(log(x), V::set(exponent)), V::set(0.0F)), scale, part);
    return V::madd(scale, part, scale);
  }
};

}  // namespace nav::render
