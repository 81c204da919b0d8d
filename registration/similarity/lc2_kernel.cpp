// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/lc2_kernel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error "the LC2 kernel tests for NaN: -ffinite-math-only would remove the tests"
#endif

namespace nav::registration {
namespace {

// The compiler's own vector types need no intrinsics; eight floats are one register on machines
// with AVX2 and two on others. Everything that patch_terms() calls is forced inline, so that it is
// compiled for AVX2 together with patch_terms().
using Float4 = float __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32)));
using Int8 = int __attribute__((vector_size(32)));
using Double4 = double __attribute__((vector_size(32)));

// Smooths |d·G| at zero, in units of f: half of the usual CT noise.
constexpr float kBeamEpsilon = 0.01f;
constexpr std::size_t kLanes = 8;
constexpr std::size_t kMaxSamples = static_cast<std::size_t>(kMaxPatchSide) * kMaxPatchSide;
constexpr std::size_t kMaxGroups = (kMaxSamples + kLanes - 1) / kLanes;
// A larger coordinate is invalid, and its conversion to an integer would be undefined.
constexpr double kMaxIndex = 1e9;

[[gnu::always_inline]] inline void splat(float x, Float8& out) {
  out = Float8{x, x, x, x, x, x, x, x};
}
/// A texel and its neighbour along i.
[[gnu::always_inline]] inline void load_pair(const std::array<float, 4>* texel, Float8& out) {
  std::memcpy(&out, texel, sizeof out);
}
[[gnu::always_inline]] inline Float4 low_half(const Float8& v) {
  return __builtin_shufflevector(v, v, 0, 1, 2, 3);
}
[[gnu::always_inline]] inline Float4 high_half(const Float8& v) {
  return __builtin_shufflevector(v, v, 4, 5, 6, 7);
}

/// Samples are processed in groups of eight, with one register for each quantity.
struct Group {
  Float8 f, g;
  std::array<Float8, 3> df;    ///< ∇f, Grid, per mm.
  std::array<Float8, 3> dg;    ///< ∇g at a fixed beam.
  std::array<Float8, 3> spin;  ///< Derivative of g by rotating the beam: (q/g) d × G.
};

/// Output of pass one and input of pass two. Lanes of the last group beyond the samples are 0.
struct Samples {
  std::array<Group, kMaxGroups> groups;
};

/// Position of each sample of a patch, in steps from its centre; a fastest. The last group is
/// padded with zeros.
struct Steps {
  alignas(32) std::array<float, kMaxGroups * kLanes> a, b;
};

constexpr std::size_t kSides = (kMaxPatchSide - 1) / 2 + 1;

constexpr std::array<Steps, kSides> all_steps() {
  std::array<Steps, kSides> all{};
  for (std::size_t s = 0; s < kSides; ++s) {
    const int half = static_cast<int>(s);
    std::size_t n = 0;
    for (int b = -half; b <= half; ++b) {
      for (int a = -half; a <= half; ++a, ++n) {
        all[s].a[n] = static_cast<float>(a);
        all[s].b[n] = static_cast<float>(b);
      }
    }
  }
  return all;
}

constexpr std::array<Steps, kSides> kSteps = all_steps();  // Indexed by (side − 1)/2.

/// Mask of the lanes of group k that are among n samples: 1, else 0.
[[gnu::always_inline]] inline void lanes_within(std::size_t k, std::size_t n, Float8& mask) {
  for (std::size_t l = 0; l < kLanes; ++l) mask[l] = k * kLanes + l < n ? 1.0f : 0.0f;
}

[[gnu::always_inline]] inline void square_root(const Float8& x, Float8& root) {
  for (std::size_t l = 0; l < kLanes; ++l) root[l] = std::sqrt(x[l]);
}

/// Texels of eight samples in memory order, one [f, gx, gy, gz] after the other: the interpolant
/// and its derivatives by the texel index.
struct Rows {
  using Eight = std::array<std::array<float, 4>, kLanes>;
  alignas(32) Eight value;
  alignas(32) std::array<Eight, 3> by;
};

/// Eight texels, one register for each of f, gx, gy, gz.
struct Columns {
  Float8 f, gx, gy, gz;
};

[[gnu::always_inline]] inline void pair_of(const std::array<float, 4>& low,
                                           const std::array<float, 4>& high, Float8& out) {
  Float4 l, h;
  std::memcpy(&l, low.data(), sizeof l);
  std::memcpy(&h, high.data(), sizeof h);
  out = __builtin_shufflevector(l, h, 0, 1, 2, 3, 4, 5, 6, 7);
}

[[gnu::always_inline]] inline void transpose(const Rows::Eight& rows, Columns& out) {
  Float8 r0, r1, r2, r3;
  pair_of(rows[0], rows[4], r0);
  pair_of(rows[1], rows[5], r1);
  pair_of(rows[2], rows[6], r2);
  pair_of(rows[3], rows[7], r3);
  const Float8 fx01 = __builtin_shufflevector(r0, r1, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float8 fx23 = __builtin_shufflevector(r2, r3, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float8 yz01 = __builtin_shufflevector(r0, r1, 2, 10, 3, 11, 6, 14, 7, 15);
  const Float8 yz23 = __builtin_shufflevector(r2, r3, 2, 10, 3, 11, 6, 14, 7, 15);
  out.f = __builtin_shufflevector(fx01, fx23, 0, 1, 8, 9, 4, 5, 12, 13);
  out.gx = __builtin_shufflevector(fx01, fx23, 2, 3, 10, 11, 6, 7, 14, 15);
  out.gy = __builtin_shufflevector(yz01, yz23, 0, 1, 8, 9, 4, 5, 12, 13);
  out.gz = __builtin_shufflevector(yz01, yz23, 2, 3, 10, 11, 6, 7, 14, 15);
}

/// Positions of eight samples. They are in memory, because a load copies one number to a whole
/// register at no cost; from another register it takes two shuffles, which would limit the kernel.
struct Locations {
  alignas(32) std::array<int, kLanes> offset;  ///< Offset of the texel corner.
  /// Fractions by axis, and the weights of the four rows of texels along i around a sample.
  alignas(32) std::array<std::array<float, kLanes>, 3> w;
  alignas(32) std::array<std::array<float, kLanes>, 4> corner;
  std::array<Float8, 3> moves;  ///< 0 if a sample was clamped along an axis, else 1.
};

/// Trilinear interpolation of one sample.
template <bool kDerivatives>
[[gnu::always_inline]] inline void interpolate(const std::array<float, 4>* first,
                                               std::ptrdiff_t row, std::ptrdiff_t slice,
                                               const Locations& at, std::size_t lane, Rows& rows) {
  const std::array<float, 4>* corner = first + at.offset[lane];
  Float8 t00, t10, t01, t11;
  load_pair(corner, t00);
  load_pair(corner + row, t10);
  load_pair(corner + slice, t01);
  load_pair(corner + slice + row, t11);
  const float wi = at.w[0][lane];
  const Float8 value = at.corner[0][lane] * t00 + at.corner[1][lane] * t10 +
                       at.corner[2][lane] * t01 + at.corner[3][lane] * t11;
  const Float4 di = high_half(value) - low_half(value);
  const Float4 middle = low_half(value) + wi * di;
  std::memcpy(&rows.value[lane], &middle, sizeof middle);
  if constexpr (kDerivatives) {
    const Float8 dj0 = t10 - t00;
    const Float8 twist = t11 - t01 - dj0;
    const Float8 dj = dj0 + at.w[2][lane] * twist;
    const Float8 dk = t01 - t00 + at.w[1][lane] * twist;
    const Float4 by_j = low_half(dj) + wi * (high_half(dj) - low_half(dj));
    const Float4 by_k = low_half(dk) + wi * (high_half(dk) - low_half(dk));
    std::memcpy(&rows.by[0][lane], &di, sizeof di);
    std::memcpy(&rows.by[1][lane], &by_j, sizeof by_j);
    std::memcpy(&rows.by[2][lane], &by_k, sizeof by_k);
  }
}

/// Fills lanes without samples with a copy of the first sample, which is finite if the samples are.
template <bool kDerivatives>
[[gnu::always_inline]] inline void repeat_first(std::size_t lanes, Rows& rows) {
  for (std::size_t lane = lanes; lane < kLanes; ++lane) {
    rows.value[lane] = rows.value[0];
    if constexpr (kDerivatives) {
      for (Rows::Eight& by : rows.by) by[lane] = by[0];
    }
  }
}

/// The patch in texel indices relative to a texel of the grid: small numbers keep floats accurate.
struct LocalPatch {
  std::ptrdiff_t base;  ///< Offset of the texel.
  std::array<float, 3> centre, step_a, step_b;
  std::array<float, 3> last;  ///< Last index of the grid, >= 1.
  bool inside;                ///< No sample needs clamping.
  bool usable;                ///< Finite and not too far away.
};

LocalPatch local_patch(const CtChannels& ct, const PlacedPatch& patch) {
  LocalPatch local{};
  const Eigen::Vector3d inverse = ct.spacing_mm.cwiseInverse();
  const Eigen::Vector3d centre = patch.centre.cwiseProduct(inverse);
  const Eigen::Vector3d a = patch.step_a.cwiseProduct(inverse);
  const Eigen::Vector3d b = patch.step_b.cwiseProduct(inverse);
  const double half = 0.5 * (patch.side - 1);
  const Eigen::Vector3d reach = half * (a.cwiseAbs() + b.cwiseAbs());
  // Written so that NaN fails.
  local.usable = (centre.cwiseAbs() + reach).maxCoeff() < kMaxIndex && centre.allFinite() &&
                 reach.allFinite() && patch.beam.allFinite();
  if (!local.usable) return local;
  local.inside = true;
  // Rounding of the relative float coordinates must not leave the grid.
  constexpr double kRim = 1e-3;
  std::array<std::ptrdiff_t, 3> base{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto e = static_cast<Eigen::Index>(axis);
    local.inside &=
        centre[e] - reach[e] >= kRim && centre[e] + reach[e] <= ct.size[axis] - 1 - kRim;
    const int first =
        std::clamp(static_cast<int>(std::floor(centre[e] - reach[e])), 0, ct.size[axis] - 2);
    base[axis] = first;
    local.centre[axis] = static_cast<float>(centre[e] - first);
    local.step_a[axis] = static_cast<float>(a[e]);
    local.step_b[axis] = static_cast<float>(b[e]);
    local.last[axis] = static_cast<float>(ct.size[axis] - 1 - first);
  }
  local.base = (base[2] * ct.size[1] + base[1]) * ct.size[0] + base[0];
  return local;
}

/// Samples outside the grid are moved to its border.
[[gnu::always_inline]] inline void locate(const CtChannels& ct, const LocalPatch& local,
                                          const Steps& steps, std::size_t group, Locations& out) {
  Float8 a, b, one;
  std::memcpy(&a, &steps.a[group * kLanes], sizeof a);
  std::memcpy(&b, &steps.b[group * kLanes], sizeof b);
  splat(1, one);
  const Float8 none{};
  std::array<Int8, 3> corner;
  std::array<Float8, 3> w;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Float8 x = local.centre[axis] + a * local.step_a[axis] + b * local.step_b[axis];
    if (local.inside) {
      corner[axis] = __builtin_convertvector(x, Int8);
      w[axis] = x - __builtin_convertvector(corner[axis], Float8);
      out.moves[axis] = one;
      continue;
    }
    const Float8 last = none + local.last[axis];
    const Float8 low = x > 0.0f ? x : none;
    const Float8 clamped = low < last ? low : last;
    out.moves[axis] = clamped == x ? one : none;
    const Float8 whole = __builtin_convertvector(__builtin_convertvector(clamped, Int8), Float8);
    const Float8 before = whole < last ? whole : last - 1.0f;
    corner[axis] = __builtin_convertvector(before, Int8);
    w[axis] = clamped - before;
  }
  const Int8 offset = (corner[2] * ct.size[1] + corner[1]) * ct.size[0] + corner[0];
  std::memcpy(out.offset.data(), &offset, sizeof offset);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::memcpy(out.w[axis].data(), &w[axis], sizeof w[axis]);
  }
  const Float8 both = w[1] * w[2];
  const std::array<Float8, 4> weights{one - w[1] - (w[2] - both), w[1] - both, w[2] - both, both};
  std::memcpy(out.corner.data(), weights.data(), sizeof weights);
}

/// Both channels of eight samples, with their derivatives if requested.
template <bool kDerivatives>
[[gnu::always_inline]] inline void finish_group(const Rows& rows, const Locations& at,
                                                const Eigen::Vector3f& inverse,
                                                const Eigen::Vector3f& d, Group& out) {
  Columns v;
  transpose(rows.value, v);
  const Float8 q = d.x() * v.gx + d.y() * v.gy + d.z() * v.gz;
  out.f = v.f;
  square_root(q * q + kBeamEpsilon * kBeamEpsilon, out.g);
  if constexpr (kDerivatives) {
    const Float8 slope = q / out.g;
    out.spin = {slope * (d.y() * v.gz - d.z() * v.gy), slope * (d.z() * v.gx - d.x() * v.gz),
                slope * (d.x() * v.gy - d.y() * v.gx)};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Columns by;
      transpose(rows.by[axis], by);
      const Float8 scale = inverse[static_cast<Eigen::Index>(axis)] * at.moves[axis];
      out.df[axis] = scale * by.f;
      out.dg[axis] = slope * scale * (d.x() * by.gx + d.y() * by.gy + d.z() * by.gz);
    }
  }
}

/// Clears the lanes of the last group beyond the samples.
template <bool kDerivatives>
[[gnu::always_inline]] inline void clear_beyond(const Float8& mask, Group& group) {
  group.f *= mask;
  group.g *= mask;
  if constexpr (kDerivatives) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      group.df[axis] *= mask;
      group.dg[axis] *= mask;
      group.spin[axis] *= mask;
    }
  }
}

[[gnu::always_inline]] inline std::size_t groups_of(std::size_t n) {
  return (n + kLanes - 1) / kLanes;
}
[[gnu::always_inline]] inline std::size_t count_of(const PlacedPatch& patch) {
  return static_cast<std::size_t>(patch.side) * static_cast<std::size_t>(patch.side);
}

/// Pass one: both channels and their derivatives at every sample. Returns false if they are not
/// finite.
template <bool kDerivatives>
[[gnu::always_inline]] inline bool sample_patch(const CtChannels& ct, const PlacedPatch& patch,
                                                Samples& out) {
  const LocalPatch local = local_patch(ct, patch);
  if (!local.usable) return false;
  const std::ptrdiff_t row = ct.size[0];
  const std::ptrdiff_t slice = row * ct.size[1];
  const std::array<float, 4>* first = ct.texels.data() + local.base;
  const Steps& steps = kSteps[static_cast<std::size_t>(patch.side / 2)];
  const Eigen::Vector3f inverse = ct.spacing_mm.cwiseInverse().cast<float>();
  const Eigen::Vector3f d = patch.beam.cast<float>();
  const std::size_t n = count_of(patch);
  const std::size_t groups = groups_of(n);
  for (std::size_t k = 0; k < groups; ++k) {
    Locations at;
    locate(ct, local, steps, k, at);
    // Forces reads from memory instead of shuffles from the registers that hold the values.
    asm("" : "+m"(at));
    Rows rows;
    if (k + 1 < groups) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        interpolate<kDerivatives>(first, row, slice, at, lane, rows);
      }
    } else {  // With 49 samples the last group has one.
      const std::size_t lanes = n - k * kLanes;
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        interpolate<kDerivatives>(first, row, slice, at, lane, rows);
      }
      repeat_first<kDerivatives>(lanes, rows);
    }
    finish_group<kDerivatives>(rows, at, inverse, d, out.groups[k]);
  }
  Float8 mask;
  lanes_within(groups - 1, n, mask);
  clear_beyond<kDerivatives>(mask, out.groups[groups - 1]);
  return true;
}

/// Solution of the eliminated 2 × 2 problem.
struct Fit {
  double s, mean_f, mean_g;
  std::array<double, 2> c;
  std::array<double, 3> inverse;  ///< S⁻¹: 00, 01, 11.
};

/// Eight floats as doubles, in two halves of four.
struct Doubles {
  Double4 low, high;
};

[[gnu::always_inline]] inline void widen(const Float8& v, Doubles& out) {
  out.low = __builtin_convertvector(low_half(v), Double4);
  out.high = __builtin_convertvector(high_half(v), Double4);
}
[[gnu::always_inline]] inline void add_product(const Doubles& a, const Doubles& b, Double4& sum) {
  sum += a.low * b.low + a.high * b.high;
}
[[gnu::always_inline]] inline double sum_of(const Double4& v) {
  return (v[0] + v[1]) + (v[2] + v[3]);
}

/// The ultrasound of group k; 0 beyond the samples.
[[gnu::always_inline]] inline void load_ultrasound(std::span<const float> u, std::size_t k,
                                                   Float8& out) {
  const std::size_t first = k * kLanes;
  if (first + kLanes <= u.size()) {
    std::memcpy(&out, u.data() + first, sizeof out);
    return;
  }
  out = Float8{};
  for (std::size_t l = 0; first + l < u.size(); ++l) out[l] = u[first + l];
}

/// Sums over the samples of a patch, without centring. In doubles, squares of values up to 3 lose
/// no relevant digits when the means are subtracted afterwards.
struct RawSums {
  Double4 f{}, g{}, u{}, ff{}, fg{}, gg{}, fu{}, gu{}, uu{};
};

[[gnu::always_inline]] inline void add_group(const Group& group, std::span<const float> u,
                                             std::size_t k, RawSums& sums) {
  Float8 ultrasound;
  load_ultrasound(u, k, ultrasound);
  Doubles f, g, v;
  widen(group.f, f);
  widen(group.g, g);
  widen(ultrasound, v);
  sums.f += f.low + f.high;
  sums.g += g.low + g.high;
  sums.u += v.low + v.high;
  add_product(f, f, sums.ff);
  add_product(f, g, sums.fg);
  add_product(g, g, sums.gg);
  add_product(f, v, sums.fu);
  add_product(g, v, sums.gu);
  add_product(v, v, sums.uu);
}

/// Subtracts the means from f and g.
[[gnu::always_inline]] inline void centre(double mean_f, double mean_g, std::size_t n,
                                          Samples& samples) {
  const std::size_t groups = groups_of(n);
  for (std::size_t k = 0; k < groups; ++k) {
    samples.groups[k].f -= static_cast<float>(mean_f);
    samples.groups[k].g -= static_cast<float>(mean_g);
  }
  Float8 mask;
  lanes_within(groups - 1, n, mask);
  clear_beyond<false>(mask, samples.groups[groups - 1]);
}

/// Solves for the coefficients.
[[gnu::always_inline]] inline Fit fit_patch(const Samples& samples, std::span<const float> u,
                                            double ridge, bool intensity_only) {
  const std::size_t n = u.size();
  RawSums sums;
  for (std::size_t k = 0; k < groups_of(n); ++k) add_group(samples.groups[k], u, k, sums);
  const double mean_f = sum_of(sums.f) / static_cast<double>(n);
  const double mean_g = sum_of(sums.g) / static_cast<double>(n);
  const double sum_u = sum_of(sums.u);
  double ff = sum_of(sums.ff) - mean_f * sum_of(sums.f);
  const double fg = sum_of(sums.fg) - mean_f * sum_of(sums.g);
  double gg = sum_of(sums.gg) - mean_g * sum_of(sums.g);
  const double fu = sum_of(sums.fu) - mean_f * sum_u;
  const double gu = sum_of(sums.gu) - mean_g * sum_u;
  const double uu = sum_of(sums.uu);
  const double damping = static_cast<double>(n) * ridge * ridge;
  ff += damping;
  gg += damping;
  const double determinant = ff * gg - fg * fg;
  Fit fit{};
  fit.mean_f = mean_f;
  fit.mean_g = mean_g;
  fit.inverse = {gg / determinant, -fg / determinant, ff / determinant};
  if (intensity_only) fit.inverse = {1 / ff, 0, 0};
  fit.c = {fit.inverse[0] * fu + fit.inverse[1] * gu, fit.inverse[1] * fu + fit.inverse[2] * gu};
  const double s = uu - fit.c[0] * fu - fit.c[1] * gu;
  // Test for NaN first: a clamp would turn it into the perfect match 0.
  fit.s = std::isfinite(s) ? std::clamp(s, 0.0, 1.0) : std::numeric_limits<double>::quiet_NaN();
  return fit;
}

/// V, one column per unknown [rotation 3 | translation 3], then f, g and u − Ac.
struct Derivatives {
  std::array<Float8, 6> v;
  Float8 f, g, residual;
};

/// Pass two: columns of V and their factors.
[[gnu::always_inline]] inline void differentiate(const Group& group, const Float8& u,
                                                 const PlacedPatch& patch, const Fit& fit,
                                                 std::size_t k, Derivatives& out) {
  const auto cf = static_cast<float>(fit.c[0]);
  const auto cg = static_cast<float>(fit.c[1]);
  const Steps& steps = kSteps[static_cast<std::size_t>(patch.side / 2)];
  Float8 a, b;
  std::memcpy(&a, &steps.a[k * kLanes], sizeof a);
  std::memcpy(&b, &steps.b[k * kLanes], sizeof b);
  std::array<Float8, 3> x, v;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto e = static_cast<Eigen::Index>(axis);
    x[axis] = a * static_cast<float>(patch.step_a[e]) + b * static_cast<float>(patch.step_b[e]);
    v[axis] = cf * group.df[axis] + cg * group.dg[axis];
    out.v[3 + axis] = v[axis];
  }
  out.v[0] = x[1] * v[2] - x[2] * v[1] + cg * group.spin[0];
  out.v[1] = x[2] * v[0] - x[0] * v[2] + cg * group.spin[1];
  out.v[2] = x[0] * v[1] - x[1] * v[0] + cg * group.spin[2];
  out.f = group.f;
  out.g = group.g;
  out.residual = u - cf * group.f - cg * group.g;
}

/// Eight sums at once: lane i of out is the sum of the lanes of s[i].
[[gnu::always_inline]] inline void sum_lanes(const Float8* s, std::array<float, 8>& out) {
  const auto halve =
      [](const Float8& a, const Float8& b, Float8& sum) __attribute__((always_inline)) {
    sum = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14) +
          __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  };
  Float8 a0, a1, a2, a3;
  halve(s[0], s[1], a0);
  halve(s[2], s[3], a1);
  halve(s[4], s[5], a2);
  halve(s[6], s[7], a3);
  const Float8 b0 = __builtin_shufflevector(a0, a1, 0, 1, 8, 9, 4, 5, 12, 13) +
                    __builtin_shufflevector(a0, a1, 2, 3, 10, 11, 6, 7, 14, 15);
  const Float8 b1 = __builtin_shufflevector(a2, a3, 0, 1, 8, 9, 4, 5, 12, 13) +
                    __builtin_shufflevector(a2, a3, 2, 3, 10, 11, 6, 7, 14, 15);
  const Float8 c = __builtin_shufflevector(b0, b1, 0, 1, 2, 3, 8, 9, 10, 11) +
                   __builtin_shufflevector(b0, b1, 4, 5, 6, 7, 12, 13, 14, 15);
  std::memcpy(out.data(), &c, sizeof c);
}

/// Sums over the samples: of V, and of its columns times f, g, the residual and each other.
struct Sums {
  std::array<float, 8> plain, f, g, residual;
  std::array<std::array<float, 8>, 6> products;  ///< Row i up to column i.
};

/// Sums of every column of V times one other register, or of V itself.
template <class Factor>
[[gnu::always_inline]] inline void sum_columns(const std::array<Derivatives, kMaxGroups>& columns,
                                               std::size_t groups, Factor factor,
                                               std::array<float, 8>& out) {
  std::array<Float8, 8> sums{};
  for (std::size_t k = 0; k < groups; ++k) {
    const Float8& with = factor(columns[k]);
    for (std::size_t i = 0; i < 6; ++i) sums[i] += columns[k].v[i] * with;
  }
  sum_lanes(sums.data(), out);
}

/// Sums of the products of column kRow of V with those up to it.
template <std::size_t kRow>
[[gnu::always_inline]] inline void sum_products(const std::array<Derivatives, kMaxGroups>& columns,
                                                std::size_t groups, Sums& out) {
  std::array<Float8, 8> sums{};
  for (std::size_t k = 0; k < groups; ++k) {
    for (std::size_t j = 0; j <= kRow; ++j) sums[j] += columns[k].v[kRow] * columns[k].v[j];
  }
  sum_lanes(sums.data(), out.products[kRow]);
}

[[gnu::always_inline]] inline double cost_of(const CtChannels& ct, const PlacedPatch& patch,
                                             double ridge, bool intensity_only) {
  Samples samples;  // Not initialised: each element is written before it is read.
  if (!sample_patch<false>(ct, patch, samples)) return std::numeric_limits<double>::quiet_NaN();
  return fit_patch(samples, patch.u, ridge, intensity_only).s;
}

/// Sums for the gradient, and for the Hessian if requested.
template <bool kHessian>
[[gnu::always_inline]] inline void accumulate(const Samples& samples, const PlacedPatch& patch,
                                              const Fit& fit, Sums& sums) {
  // Not initialised: each element is written before it is read.
  std::array<Derivatives, kMaxGroups> columns;
  const std::size_t groups = groups_of(patch.u.size());
  for (std::size_t k = 0; k < groups; ++k) {
    Float8 u;
    load_ultrasound(patch.u, k, u);
    differentiate(samples.groups[k], u, patch, fit, k, columns[k]);
  }
  const auto residual = [](const Derivatives& c) -> const Float8& { return c.residual; };
  sum_columns(columns, groups, residual, sums.residual);
  if constexpr (kHessian) {
    std::array<Float8, 8> plain{};
    for (std::size_t k = 0; k < groups; ++k) {
      for (std::size_t i = 0; i < 6; ++i) plain[i] += columns[k].v[i];
    }
    sum_lanes(plain.data(), sums.plain);
    sum_columns(
        columns, groups, [](const Derivatives& c) -> const Float8& { return c.f; }, sums.f);
    sum_columns(
        columns, groups, [](const Derivatives& c) -> const Float8& { return c.g; }, sums.g);
    sum_products<0>(columns, groups, sums);
    sum_products<1>(columns, groups, sums);
    sum_products<2>(columns, groups, sums);
    sum_products<3>(columns, groups, sums);
    sum_products<4>(columns, groups, sums);
    sum_products<5>(columns, groups, sums);
  }
}

template <bool kHessian>
[[gnu::always_inline]] inline PatchTerms terms_of(const CtChannels& ct, const PlacedPatch& patch,
                                                  double ridge, bool intensity_only) {
  PatchTerms terms{std::numeric_limits<double>::quiet_NaN(), Vector6d::Zero(), Matrix6d::Zero()};
  Samples samples;  // Not initialised: each element is written before it is read.
  if (!sample_patch<true>(ct, patch, samples)) return terms;
  const Fit fit = fit_patch(samples, patch.u, ridge, intensity_only);
  if (std::isnan(fit.s)) return terms;
  centre(fit.mean_f, fit.mean_g, patch.u.size(), samples);
  Sums sums;
  accumulate<kHessian>(samples, patch, fit, sums);
  for (std::size_t r = 0; r < 6; ++r) {
    terms.gradient[static_cast<Eigen::Index>(r)] = -static_cast<double>(sums.residual[r]);
  }
  if constexpr (kHessian) {
    const double count = static_cast<double>(patch.u.size());
    for (std::size_t r = 0; r < 6; ++r) {
      const auto i = static_cast<Eigen::Index>(r);
      const double af = sums.f[r];
      const double ag = sums.g[r];
      for (std::size_t c = 0; c <= r; ++c) {
        const auto j = static_cast<Eigen::Index>(c);
        const double projected = af * (fit.inverse[0] * sums.f[c] + fit.inverse[1] * sums.g[c]) +
                                 ag * (fit.inverse[1] * sums.f[c] + fit.inverse[2] * sums.g[c]);
        const double means =
            static_cast<double>(sums.plain[r]) * static_cast<double>(sums.plain[c]) / count;
        terms.hessian(i, j) = static_cast<double>(sums.products[r][c]) - means - projected;
        terms.hessian(j, i) = terms.hessian(i, j);
      }
    }
  }
  if (terms.gradient.allFinite() && terms.hessian.allFinite()) terms.s = fit.s;
  return terms;
}

#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] double cost_avx2(const CtChannels& ct, const PlacedPatch& patch,
                                             double ridge, bool intensity_only) {
  return cost_of(ct, patch, ridge, intensity_only);
}
[[gnu::target("avx2,fma")]] PatchTerms gradient_avx2(const CtChannels& ct, const PlacedPatch& patch,
                                                     double ridge, bool intensity_only) {
  return terms_of<false>(ct, patch, ridge, intensity_only);
}
[[gnu::target("avx2,fma")]] PatchTerms terms_avx2(const CtChannels& ct, const PlacedPatch& patch,
                                                  double ridge, bool intensity_only) {
  return terms_of<true>(ct, patch, ridge, intensity_only);
}
bool has_avx2() {
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  return has;
}
#endif

}  // namespace

double patch_cost(const CtChannels& ct, const PlacedPatch& patch, double ridge,
                  bool intensity_only) {
#if defined(__x86_64__)
  if (has_avx2()) return cost_avx2(ct, patch, ridge, intensity_only);
#endif
  return cost_of(ct, patch, ridge, intensity_only);
}

PatchTerms patch_gradient(const CtChannels& ct, const PlacedPatch& patch, double ridge,
                          bool intensity_only) {
#if defined(__x86_64__)
  if (has_avx2()) return gradient_avx2(ct, patch, ridge, intensity_only);
#endif
  return terms_of<false>(ct, patch, ridge, intensity_only);
}

PatchTerms patch_terms(const CtChannels& ct, const PlacedPatch& patch, double ridge,
                       bool intensity_only) {
#if defined(__x86_64__)
  if (has_avx2()) return terms_avx2(ct, patch, ridge, intensity_only);
#endif
  return terms_of<true>(ct, patch, ridge, intensity_only);
}

bool patch_intensities(const CtChannels& ct, const PlacedPatch& patch, std::span<float> f,
                       std::span<Eigen::Vector3f> by_point) {
  Samples samples;  // Not initialised: each element is written before it is read.
  const bool slopes = !by_point.empty();
  if (slopes ? !sample_patch<true>(ct, patch, samples) : !sample_patch<false>(ct, patch, samples)) {
    return false;
  }
  for (std::size_t k = 0; k < f.size(); ++k) {
    const Group& group = samples.groups[k / kLanes];
    const std::size_t lane = k % kLanes;
    f[k] = group.f[lane];
    if (!std::isfinite(f[k])) return false;
    if (!slopes) continue;
    by_point[k] = {group.df[0][lane], group.df[1][lane], group.df[2][lane]};
    if (!by_point[k].allFinite()) return false;
  }
  return true;
}

}  // namespace nav::registration
