// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The inner loops on vector types of the compiler (GCC and Clang), which maps them to the
// instructions of the processor. One source file for each instruction set includes this file inside
// its own unnamed namespace. The file must not use inline functions of other files: the linker
// would merge these across the instruction sets, and they would then fail on an older processor.

using Floats = float __attribute__((vector_size(32)));
using Ints = int __attribute__((vector_size(32)));
using LooseFloats = float __attribute__((vector_size(32), aligned(4), may_alias));
using Doubles = double __attribute__((vector_size(32)));
using LooseDoubles = double __attribute__((vector_size(32), aligned(8), may_alias));

#define SONDE_INLINE [[gnu::always_inline]] static inline

SONDE_INLINE Floats load(const float* from) { return *reinterpret_cast<const LooseFloats*>(from); }
SONDE_INLINE void store(float* to, Floats v) { *reinterpret_cast<LooseFloats*>(to) = v; }
SONDE_INLINE Doubles load(const double* from) {
  return *reinterpret_cast<const LooseDoubles*>(from);
}
SONDE_INLINE void store(double* to, Doubles v) { *reinterpret_cast<LooseDoubles*>(to) = v; }
SONDE_INLINE Floats all(float v) { return Floats{v, v, v, v, v, v, v, v}; }
SONDE_INLINE Floats select(Ints mask, Floats a, Floats b) {
  return reinterpret_cast<Floats>((mask & reinterpret_cast<Ints>(a)) |
                                  (~mask & reinterpret_cast<Ints>(b)));
}
SONDE_INLINE Floats max_of(Floats a, Floats b) { return select(a > b, a, b); }
SONDE_INLINE Floats min_of(Floats a, Floats b) { return select(a < b, a, b); }
SONDE_INLINE Floats abs_of(Floats a) {
  return reinterpret_cast<Floats>(reinterpret_cast<Ints>(a) & 0x7fffffff);
}
SONDE_INLINE bool any(Ints mask) {
#ifdef __AVX2__
  return _mm256_movemask_ps(reinterpret_cast<__m256>(mask)) != 0;
#else
  int joined = 0;
  for (int i = 0; i < 8; ++i) joined |= mask[i];
  return joined != 0;
#endif
}
SONDE_INLINE Floats sqrt_of(Floats a) {
#ifdef __AVX2__
  return reinterpret_cast<Floats>(_mm256_sqrt_ps(reinterpret_cast<__m256>(a)));
#else
  Floats out = a;
  for (int i = 0; i < 8; ++i) out[i] = __builtin_sqrtf(a[i]);
  return out;
#endif
}

/// exp(-x) for x >= 0, relative error below 3e-7; practically 0 from x = 80 on.
SONDE_INLINE Floats exp_minus(Floats x) {
  const Floats t = min_of(x, all(80.0F)) * -1.44269504F;
  constexpr float kRounder = 12582912.0F;  // 1.5 * 2^23: adding it rounds to integers.
  const Floats whole = (t + kRounder) - kRounder;
  const Floats f = (t - whole) * 0.693147181F;
  // Taylor series: the eighth term is below 2e-8 for |f| <= ln(2) / 2.
  Floats p = all(1.0F / 5040);
  p = p * f + 1.0F / 720;
  p = p * f + 1.0F / 120;
  p = p * f + 1.0F / 24;
  p = p * f + 1.0F / 6;
  p = p * f + 0.5F;
  p = p * f + 1.0F;
  p = p * f + 1.0F;
  const Ints exponent = (__builtin_convertvector(whole, Ints) + 127) << 23;
  return p * reinterpret_cast<Floats>(exponent);
}

/// 1 - exp(-x) without cancellation for small x.
SONDE_INLINE Floats one_minus_exp_minus(Floats x) {
  const Floats series = x * (1.0F - x * (0.5F - x * (1.0F / 6 - x * (1.0F / 24))));
  return select(x < 0.03F, series, 1.0F - exp_minus(x));
}

/// Angle of (x, y), y >= 0, in [0, pi]; 0 for (0, 0).
SONDE_INLINE Floats angle_of(Floats x, Floats y) {
  const Floats ax = abs_of(x);
  const Ints steep = y > ax;
  const Floats large = select(steep, y, ax);
  const Floats small = select(steep, ax, y);
  Floats t = small / select(large > 0.0F, large, all(1.0F));
  const Ints reduce = t > 0.414213562F;  // tan(pi / 8)
  t = select(reduce, (t - 1.0F) / (t + 1.0F), t);
  const Floats z = t * t;
  // Taylor series to t^15: the next term is below 2e-8 for |t| <= tan(pi / 8).
  Floats p = all(-1.0F / 15);
  p = p * z + 1.0F / 13;
  p = p * z - 1.0F / 11;
  p = p * z + 1.0F / 9;
  p = p * z - 1.0F / 7;
  p = p * z + 1.0F / 5;
  p = p * z - 1.0F / 3;
  p = p * z * t + t;
  Floats angle = select(reduce, p + 0.785398163F, p);
  angle = select(steep, 1.57079633F - angle, angle);
  return select(x < 0.0F, 3.14159265F - angle, angle);
}

SONDE_INLINE Floats minor2(Floats bi, Floats cj, Floats bj, Floats ci) {
  const Floats minor = bi * cj - bj * ci;
  return minor * minor;
}

struct Eigen3 {
  Floats low, middle, high;
};

/// Ascending eigenvalues of symmetric 3 x 3 matrices, in closed form. The eigenvalues of the
/// deviator B = A - m I are sqrt(2/3) |B| cos(t + 2 pi k / 3). 3 t is the angle between B and
/// dev(B^2) as vectors (five orthonormal coordinates of traceless symmetric matrices). It is
/// computed by atan2 of their wedge product, a sum of squares, and their scalar product. This keeps
/// full accuracy for nearly equal eigenvalues; the usual arccosine of the determinant loses half of
/// the digits there.
SONDE_INLINE Eigen3 eigenvalues_of(Floats xx, Floats yy, Floats zz, Floats xy, Floats xz,
                                   Floats yz) {
  constexpr float kRoot2 = 1.41421356F;
  constexpr float kInvRoot2 = 0.707106781F;
  constexpr float kInvRoot6 = 0.40824829F;
  const Floats mean = (xx + yy + zz) * (1.0F / 3);
  const Floats a = xx - mean;
  const Floats b = yy - mean;
  const Floats c = zz - mean;
  const Floats norm2 = a * a + b * b + c * c + 2.0F * (xy * xy + xz * xz + yz * yz);
  const Ints round = norm2 < 1e-36F;  // In float, a multiple of the identity.
  const Floats norm = sqrt_of(norm2);
  const Floats scale = 1.0F / select(round, all(1.0F), norm);
  const Floats p = a * scale, q = b * scale, r = c * scale;
  const Floats u = xy * scale, v = xz * scale, w = yz * scale;
  const Floats b0 = (p - q) * kInvRoot2, b1 = (p + q - 2.0F * r) * kInvRoot6;
  const Floats b2 = u * kRoot2, b3 = v * kRoot2, b4 = w * kRoot2;
  const Floats s0 = p * p + u * u + v * v, s1 = q * q + u * u + w * w, s2 = r * r + v * v + w * w;
  const Floats c0 = (s0 - s1) * kInvRoot2, c1 = (s0 + s1 - 2.0F * s2) * kInvRoot6;
  const Floats c2 = (p * u + u * q + v * w) * kRoot2;
  const Floats c3 = (p * v + u * w + v * r) * kRoot2;
  const Floats c4 = (u * v + q * w + w * r) * kRoot2;
  const Floats dot = b0 * c0 + b1 * c1 + b2 * c2 + b3 * c3 + b4 * c4;
  const Floats wedge2 = minor2(b0, c1, b1, c0) + minor2(b0, c2, b2, c0) + minor2(b0, c3, b3, c0) +
                        minor2(b0, c4, b4, c0) + minor2(b1, c2, b2, c1) + minor2(b1, c3, b3, c1) +
                        minor2(b1, c4, b4, c1) + minor2(b2, c3, b3, c2) + minor2(b2, c4, b4, c2) +
                        minor2(b3, c4, b4, c3);
  const Floats t = angle_of(dot, sqrt_of(wedge2)) * (1.0F / 3);
  const Floats z = t * t;  // t in [0, pi / 3]: Taylor series, next terms below 4e-9.
  const Floats sine =
      t * (1.0F -
           z * (1.0F / 6 - z * (1.0F / 120 -
                                z * (1.0F / 5040 - z * (1.0F / 362880 - z * (1.0F / 39916800))))));
  const Floats cosine =
      1.0F -
      z * (0.5F - z * (1.0F / 24 - z * (1.0F / 720 - z * (1.0F / 40320 - z * (1.0F / 3628800)))));
  const Floats radius = select(round, all(0.0F), norm) * 0.816496581F;  // sqrt(2 / 3)
  const Floats half = -0.5F * cosine;
  const Floats side = 0.866025404F * sine;
  return {mean + radius * (half - side), mean + radius * (half + side), mean + radius * cosine};
}

static void eigenvalue_rows(const HessianRows& h, float* low, float* middle, float* high,
                            int count) {
  for (int i = 0; i < count; i += 8) {
    const Eigen3 e = eigenvalues_of(load(h.xx + i), load(h.yy + i), load(h.zz + i), load(h.xy + i),
                                    load(h.xz + i), load(h.yz + i));
    store(low + i, e.low);
    store(middle + i, e.middle);
    store(high + i, e.high);
  }
}

SONDE_INLINE void order_by_size(Floats& smaller, Floats& larger) {
  const Ints swap = abs_of(smaller) > abs_of(larger);
  const Floats first = select(swap, larger, smaller);
  larger = select(swap, smaller, larger);
  smaller = first;
}

static void tube_rows(const HessianRows& h, const TubeConstants& k, float* best, int count) {
  for (int i = 0; i < count; i += 8) {
    const Floats xx = load(h.xx + i) * k.sign, yy = load(h.yy + i) * k.sign;
    const Floats zz = load(h.zz + i) * k.sign;
    // Two eigenvalues must be positive and no smaller than the third, so the trace must be positive
    // too.
    if (!any(xx + yy + zz > 0.0F)) continue;
    const Eigen3 e = eigenvalues_of(xx, yy, zz, load(h.xy + i) * k.sign, load(h.xz + i) * k.sign,
                                    load(h.yz + i) * k.sign);
    Floats l1 = e.low, l2 = e.middle, l3 = e.high;
    order_by_size(l1, l2);
    order_by_size(l2, l3);
    order_by_size(l1, l2);
    const Ints tube = (l2 > 0.0F) & (l3 > 0.0F);
    const Floats safe2 = select(tube, l2, all(1.0F));
    const Floats safe3 = select(tube, l3, all(1.0F));
    const Floats ratio = safe2 / safe3;
    const Floats blob = l1 * l1 / (safe2 * safe3);
    const Floats size = l1 * l1 + l2 * l2 + l3 * l3;
    const Floats response = one_minus_exp_minus(ratio * ratio * k.plate) *
                            exp_minus(blob * k.blob) * one_minus_exp_minus(size * k.structure);
    const Floats before = load(best + i);
    store(best + i, select(tube, max_of(before, response), before));
  }
}

template <bool kSmooth, bool kSlope, bool kBend>
static void filter(const float* const* rows, int radius, const FoldedTaps& taps,
                   float* const out[3], int count) {
  const float* const* middle = rows + radius;
  for (int i = 0; i < count; i += 8) {
    const Floats centre = load(middle[0] + i);
    Floats smooth = centre * taps.smooth[0];
    Floats slope = all(0.0F);
    Floats bend = centre * taps.bend[0];
    for (int k = 1; k <= radius; ++k) {
      const Floats after = load(middle[k] + i);
      const Floats before = load(middle[-k] + i);
      const Floats sum = after + before;
      if constexpr (kSmooth) smooth += sum * taps.smooth[k];
      if constexpr (kSlope) slope += (after - before) * taps.slope[k];
      if constexpr (kBend) bend += sum * taps.bend[k];
    }
    if constexpr (kSmooth) store(out[0] + i, smooth);
    if constexpr (kSlope) store(out[1] + i, slope);
    if constexpr (kBend) store(out[2] + i, bend);
  }
}

static void filter_any(const float* const* rows, int radius, const FoldedTaps& taps,
                       float* const out[3], int count) {
  using Filter = void (*)(const float* const*, int, const FoldedTaps&, float* const[3], int);
  static constexpr Filter kFilters[8] = {filter<false, false, false>, filter<true, false, false>,
                                         filter<false, true, false>,  filter<true, true, false>,
                                         filter<false, false, true>,  filter<true, false, true>,
                                         filter<false, true, true>,   filter<true, true, true>};
  const int which =
      (out[0] != nullptr ? 1 : 0) + (out[1] != nullptr ? 2 : 0) + (out[2] != nullptr ? 4 : 0);
  kFilters[which](rows, radius, taps, out, count);
}

/// Chan, Golub, LeVeque 1983: the spread of a union is the sum of the spreads plus the weighted
/// squared distances of the means from the joint mean. Nothing is ever subtracted from a sum of
/// squares.
static void merge_rows(const ConstMomentRows* windows, const double* weights, int windows_count,
                       const MomentRows& out, int count) {
  for (int i = 0; i < count; i += 4) {
    Doubles total{};
    Doubles sum{};
    for (int t = 0; t < windows_count; ++t) {
      const Doubles weight = load(windows[t].weight + i) * weights[t];
      total += weight;
      sum += weight * load(windows[t].mean + i);
    }
    Doubles nonzero = total;
    for (int lane = 0; lane < 4; ++lane) nonzero[lane] = total[lane] > 0 ? total[lane] : 1.0;
    const Doubles mean = sum / nonzero;
    Doubles spread{};
    for (int t = 0; t < windows_count; ++t) {
      const Doubles away = load(windows[t].mean + i) - mean;
      spread +=
          weights[t] * (load(windows[t].spread + i) + load(windows[t].weight + i) * away * away);
    }
    store(out.weight + i, total);
    store(out.mean + i, mean);
    store(out.spread + i, spread);
  }
}

#include "render/features/graph_kernels_body.hpp"

static constexpr Kernels make_kernels(const char* name) {
  return {.name = name,
          .filter_rows = filter_any,
          .tube_response = tube_rows,
          .eigenvalues = eigenvalue_rows,
          .merge_moments = merge_rows,
          .laplacian = laplacian_rows,
          .packed_laplacian = packed_laplacian_rows,
          .packed_residual = packed_residual_rows,
          .line_forward = line_forward_rows,
          .line_backward = line_backward_rows,
          .damped_step = damped_step_rows,
          .dot = dot_rows,
          .step = step_rows,
          .edge_penalties = edge_penalty_rows,
          .edge_weights = edge_weight_rows};
}

#undef SONDE_INLINE
