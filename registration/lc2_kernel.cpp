// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/lc2_kernel.hpp"

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

// Floats in one register. The compiler's own vectors need no intrinsics; eight of them are one
// register where the machine has AVX2 and two elsewhere. Everything that patch_terms() calls is
// inlined by force, so that it is compiled for AVX2 where patch_terms() is.
using Float4 = float __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32)));
using Double4 = double __attribute__((vector_size(32)));

// Smooths |d·G| at zero, in the unit of f: half the usual CT noise.
constexpr float kBeamEpsilon = 0.01f;
constexpr int kMaxSamples = kMaxPatchSide * kMaxPatchSide;
// Beyond this a coordinate is nonsense, and converting it to an integer undefined.
constexpr double kMaxIndex = 1e9;

[[gnu::always_inline]] inline Float4 splat(float x) { return Float4{x, x, x, x}; }
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

/// One interpolated sample with the derivatives of the interpolant by the texel index.
struct Sample {
  Float4 value, di, dj, dk;
};

/// Trilinear interpolation at integer corner + fractions.
template <bool kDerivatives>
[[gnu::always_inline]] inline void interpolate(const std::array<float, 4>* corner,
                                               std::ptrdiff_t row, std::ptrdiff_t slice, float wi,
                                               float wj, float wk, Sample& sample) {
  const Float4 i = splat(wi);
  Float8 j, k, t00, t10, t01, t11;
  splat(wj, j);
  splat(wk, k);
  load_pair(corner, t00);
  load_pair(corner + row, t10);
  load_pair(corner + slice, t01);
  load_pair(corner + slice + row, t11);
  const Float8 dj0 = t10 - t00;
  const Float8 dj1 = t11 - t01;
  const Float8 a0 = t00 + j * dj0;
  const Float8 dk = t01 + j * dj1 - a0;
  const Float8 value = a0 + k * dk;
  const Float4 di = high_half(value) - low_half(value);
  sample.value = low_half(value) + i * di;
  if constexpr (kDerivatives) {
    const Float8 dj = dj0 + k * (dj1 - dj0);
    sample.di = di;
    sample.dj = low_half(dj) + i * (high_half(dj) - low_half(dj));
    sample.dk = low_half(dk) + i * (high_half(dk) - low_half(dk));
  }
}

/// What pass one leaves for pass two.
struct Samples {
  alignas(32) std::array<float, kMaxSamples> f, g;
  std::array<Float4, kMaxSamples> df;    ///< ∇f, Grid, per mm.
  std::array<Float4, kMaxSamples> dg;    ///< ∇g at a fixed beam.
  std::array<Float4, kMaxSamples> spin;  ///< Derivative of g by turning the beam: (q/g) d × G.
};

/// Where a sample lies: texel corner and fractions; moves[axis] is 0 where it was clamped.
struct Location {
  std::ptrdiff_t offset;
  std::array<float, 3> w;
  std::array<float, 3> moves;
};

[[gnu::always_inline]] inline std::ptrdiff_t offset_of(const CtChannels& ct, int i, int j, int k) {
  return (static_cast<std::ptrdiff_t>(k) * ct.size[1] + j) * ct.size[0] + i;
}

/// General and slow: clamps into the grid.
Location clamped_location(const CtChannels& ct, const Eigen::Vector3d& index) {
  Location location{};
  std::array<int, 3> base{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double last = ct.size[axis] - 1;
    const double x = index[static_cast<Eigen::Index>(axis)];
    const double inside = std::clamp(x, 0.0, last);
    location.moves[axis] = inside == x ? 1.0f : 0.0f;
    base[axis] = std::min(static_cast<int>(inside), ct.size[axis] - 2);
    location.w[axis] = static_cast<float>(inside - base[axis]);
  }
  location.offset = offset_of(ct, base[0], base[1], base[2]);
  return location;
}

/// The patch in texel indices relative to an integer corner: small numbers keep floats exact.
struct LocalPatch {
  std::array<int, 3> base;
  std::array<float, 3> centre, step_a, step_b;
  bool inside;  ///< No sample needs clamping.
  bool usable;  ///< Finite and not absurdly far.
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
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto e = static_cast<Eigen::Index>(axis);
    const double low = centre[e] - reach[e];
    local.inside &= low >= kRim && centre[e] + reach[e] <= ct.size[axis] - 1 - kRim;
    local.base[axis] = static_cast<int>(std::floor(low));
    local.centre[axis] = static_cast<float>(centre[e] - local.base[axis]);
    local.step_a[axis] = static_cast<float>(a[e]);
    local.step_b[axis] = static_cast<float>(b[e]);
  }
  return local;
}

template <bool kDerivatives>
[[gnu::always_inline]] inline void store(const Sample& sample, const Location& location,
                                         const Eigen::Vector3f& inverse, const Eigen::Vector3f& d,
                                         std::size_t n, Samples& out) {
  const Float4 v = sample.value;
  const float q = d.x() * v[1] + d.y() * v[2] + d.z() * v[3];
  const float g = std::sqrt(q * q + kBeamEpsilon * kBeamEpsilon);
  out.f[n] = v[0];
  out.g[n] = g;
  if constexpr (kDerivatives) {
    const Float4 scale{inverse.x() * location.moves[0], inverse.y() * location.moves[1],
                       inverse.z() * location.moves[2], 0};
    out.df[n] = scale * Float4{sample.di[0], sample.dj[0], sample.dk[0], 0};
    const Float4 dq = splat(d.x()) * Float4{sample.di[1], sample.dj[1], sample.dk[1], 0} +
                      splat(d.y()) * Float4{sample.di[2], sample.dj[2], sample.dk[2], 0} +
                      splat(d.z()) * Float4{sample.di[3], sample.dj[3], sample.dk[3], 0};
    const float slope = q / g;
    out.dg[n] = splat(slope) * scale * dq;
    out.spin[n] = splat(slope) * Float4{d.y() * v[3] - d.z() * v[2], d.z() * v[1] - d.x() * v[3],
                                        d.x() * v[2] - d.y() * v[1], 0};
  }
}

/// Pass one: both channels and their derivatives at every sample. False: not finite.
template <bool kDerivatives>
[[gnu::always_inline]] inline bool sample_patch(const CtChannels& ct, const PlacedPatch& patch,
                                                Samples& out) {
  const LocalPatch local = local_patch(ct, patch);
  if (!local.usable) return false;
  const std::ptrdiff_t row = ct.size[0];
  const std::ptrdiff_t slice = row * ct.size[1];
  const Eigen::Vector3d inverse_d = ct.spacing_mm.cwiseInverse();
  const Eigen::Vector3f inverse = inverse_d.cast<float>();
  const Eigen::Vector3f d = patch.beam.cast<float>();
  const int half = (patch.side - 1) / 2;
  std::size_t n = 0;
  for (int b = -half; b <= half; ++b) {
    for (int a = -half; a <= half; ++a, ++n) {
      Location location{};
      if (local.inside) {
        std::array<int, 3> corner{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const float x = local.centre[axis] + static_cast<float>(a) * local.step_a[axis] +
                          static_cast<float>(b) * local.step_b[axis];
          const int whole = static_cast<int>(x);
          corner[axis] = local.base[axis] + whole;
          location.w[axis] = x - static_cast<float>(whole);
          location.moves[axis] = 1;
        }
        location.offset = offset_of(ct, corner[0], corner[1], corner[2]);
      } else {
        location = clamped_location(
            ct, (patch.centre + a * patch.step_a + b * patch.step_b).cwiseProduct(inverse_d));
      }
      Sample sample;
      interpolate<kDerivatives>(ct.texels.data() + location.offset, row, slice, location.w[0],
                                location.w[1], location.w[2], sample);
      store<kDerivatives>(sample, location, inverse, d, n, out);
    }
  }
  return true;
}

/// The eliminated 2 × 2 problem.
struct Fit {
  double s;
  std::array<double, 2> c;
  std::array<double, 3> inverse;  ///< S⁻¹: 00, 01, 11.
};

[[gnu::always_inline]] inline void load_doubles(const float* values, Double4& out) {
  Float4 four;
  std::memcpy(&four, values, sizeof four);
  out = __builtin_convertvector(four, Double4);
}
[[gnu::always_inline]] inline double sum_of(const Double4& v) {
  return (v[0] + v[1]) + (v[2] + v[3]);
}

/// Sums over the samples of a patch, centred.
struct Moments {
  double ff = 0, fg = 0, gg = 0, fu = 0, gu = 0, uu = 0;
};

/// Takes the means from f and g. Four sums side by side: one after the other would wait for each
/// addition.
[[gnu::always_inline]] inline Moments centre(Samples& samples, std::span<const float> u) {
  const std::size_t n = u.size();
  const std::size_t whole = n / 4 * 4;
  Double4 sum_f{}, sum_g{}, f, g, v;
  for (std::size_t k = 0; k < whole; k += 4) {
    load_doubles(&samples.f[k], f);
    load_doubles(&samples.g[k], g);
    sum_f += f;
    sum_g += g;
  }
  double mean_f = sum_of(sum_f);
  double mean_g = sum_of(sum_g);
  for (std::size_t k = whole; k < n; ++k) {
    mean_f += samples.f[k];
    mean_g += samples.g[k];
  }
  const auto mf = static_cast<float>(mean_f / static_cast<double>(n));
  const auto mg = static_cast<float>(mean_g / static_cast<double>(n));
  for (std::size_t k = 0; k < n; ++k) {
    samples.f[k] -= mf;
    samples.g[k] -= mg;
  }
  Double4 ff{}, fg{}, gg{}, fu{}, gu{}, uu{};
  for (std::size_t k = 0; k < whole; k += 4) {
    load_doubles(&samples.f[k], f);
    load_doubles(&samples.g[k], g);
    load_doubles(&u[k], v);
    ff += f * f;
    fg += f * g;
    gg += g * g;
    fu += f * v;
    gu += g * v;
    uu += v * v;
  }
  Moments sums{sum_of(ff), sum_of(fg), sum_of(gg), sum_of(fu), sum_of(gu), sum_of(uu)};
  for (std::size_t k = whole; k < n; ++k) {
    const double x = samples.f[k];
    const double y = samples.g[k];
    const double z = u[k];
    sums.ff += x * x;
    sums.fg += x * y;
    sums.gg += y * y;
    sums.fu += x * z;
    sums.gu += y * z;
    sums.uu += z * z;
  }
  return sums;
}

/// Centres f and g in place and solves for the coefficients.
[[gnu::always_inline]] inline Fit fit_patch(Samples& samples, std::span<const float> u,
                                            double ridge, bool intensity_only) {
  const std::size_t n = u.size();
  auto [ff, fg, gg, fu, gu, uu] = centre(samples, u);
  const double damping = static_cast<double>(n) * ridge * ridge;
  ff += damping;
  gg += damping;
  const double determinant = ff * gg - fg * fg;
  Fit fit{};
  fit.inverse = {gg / determinant, -fg / determinant, ff / determinant};
  if (intensity_only) fit.inverse = {1 / ff, 0, 0};
  fit.c = {fit.inverse[0] * fu + fit.inverse[1] * gu, fit.inverse[1] * fu + fit.inverse[2] * gu};
  const double s = uu - fit.c[0] * fu - fit.c[1] * gu;
  // NaN first: a clamp would turn it into the perfect match 0.
  fit.s = std::isfinite(s) ? std::clamp(s, 0.0, 1.0) : std::numeric_limits<double>::quiet_NaN();
  return fit;
}

/// Sums of w wᵀ with w = [rotation 3, f, translation 3, g], of w and of (u − Ac) w.
struct Sums {
  std::array<Float8, 6> products;  ///< Rows of the six unknowns.
  Float8 plain, residual;
};
constexpr std::array<int, 6> kUnknown{0, 1, 2, 4, 5, 6};  ///< Where they stand in w.
constexpr int kF = 3;
constexpr int kG = 7;

template <int kLane>
[[gnu::always_inline]] inline void add_row(const Float8& w, Float8& row) {
  row += __builtin_shufflevector(w, w, kLane, kLane, kLane, kLane, kLane, kLane, kLane, kLane) * w;
}

/// Pass two: V rows and their products.
[[gnu::always_inline]] inline void accumulate(const Samples& samples, const PlacedPatch& patch,
                                              const Fit& fit, Sums& sums) {
  const Float4 cf = splat(static_cast<float>(fit.c[0]));
  const Float4 cg = splat(static_cast<float>(fit.c[1]));
  const Eigen::Vector3f da = patch.step_a.cast<float>();
  const Eigen::Vector3f db = patch.step_b.cast<float>();
  const Float4 step_a{da[0], da[1], da[2], 0};
  const Float4 step_b{db[0], db[1], db[2], 0};
  const int half = (patch.side - 1) / 2;
  std::array<Float8, 6> products{};
  Float8 plain{}, residual{}, factor;
  std::size_t n = 0;
  for (int b = -half; b <= half; ++b) {
    Float4 x = splat(static_cast<float>(b)) * step_b - splat(static_cast<float>(half)) * step_a;
    for (int a = -half; a <= half; ++a, ++n, x += step_a) {
      const Float4 v = cf * samples.df[n] + cg * samples.dg[n];
      const Float4 x1 = __builtin_shufflevector(x, x, 1, 2, 0, 3);
      const Float4 x2 = __builtin_shufflevector(x, x, 2, 0, 1, 3);
      const Float4 v1 = __builtin_shufflevector(v, v, 1, 2, 0, 3);
      const Float4 v2 = __builtin_shufflevector(v, v, 2, 0, 1, 3);
      // Lane 3 of all of these is 0, so that f and g find room there.
      const float f = samples.f[n];
      const float g = samples.g[n];
      const Float4 low = x1 * v2 - x2 * v1 + cg * samples.spin[n] + Float4{0, 0, 0, f};
      const Float4 high = v + Float4{0, 0, 0, g};
      const Float8 w = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
      add_row<0>(w, products[0]);
      add_row<1>(w, products[1]);
      add_row<2>(w, products[2]);
      add_row<4>(w, products[3]);
      add_row<5>(w, products[4]);
      add_row<6>(w, products[5]);
      splat(patch.u[n] - cf[0] * f - cg[0] * g, factor);
      plain += w;
      residual += factor * w;
    }
  }
  sums = {products, plain, residual};
}

[[gnu::always_inline]] inline double cost_of(const CtChannels& ct, const PlacedPatch& patch,
                                             double ridge, bool intensity_only) {
  Samples samples;  // Not initialised: each element used is written first.
  if (!sample_patch<false>(ct, patch, samples)) return std::numeric_limits<double>::quiet_NaN();
  return fit_patch(samples, patch.u, ridge, intensity_only).s;
}

[[gnu::always_inline]] inline PatchTerms terms_of(const CtChannels& ct, const PlacedPatch& patch,
                                                  double ridge, bool intensity_only) {
  PatchTerms terms{std::numeric_limits<double>::quiet_NaN(), Vector6d::Zero(), Matrix6d::Zero()};
  Samples samples;  // Not initialised: each element used is written first.
  if (!sample_patch<true>(ct, patch, samples)) return terms;
  const Fit fit = fit_patch(samples, patch.u, ridge, intensity_only);
  if (std::isnan(fit.s)) return terms;
  Sums sums;
  accumulate(samples, patch, fit, sums);
  const double count = static_cast<double>(patch.u.size());
  for (std::size_t r = 0; r < 6; ++r) {
    const auto i = static_cast<Eigen::Index>(r);
    const double af = sums.products[r][kF];
    const double ag = sums.products[r][kG];
    terms.gradient[i] = -static_cast<double>(sums.residual[kUnknown[r]]);
    for (std::size_t c = 0; c <= r; ++c) {
      const auto j = static_cast<Eigen::Index>(c);
      const double bf = sums.products[c][kF];
      const double bg = sums.products[c][kG];
      const double projected = af * (fit.inverse[0] * bf + fit.inverse[1] * bg) +
                               ag * (fit.inverse[1] * bf + fit.inverse[2] * bg);
      const double means = static_cast<double>(sums.plain[kUnknown[r]]) *
                           static_cast<double>(sums.plain[kUnknown[c]]) / count;
      terms.hessian(i, j) = static_cast<double>(sums.products[r][kUnknown[c]]) - means - projected;
      terms.hessian(j, i) = terms.hessian(i, j);
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
[[gnu::target("avx2,fma")]] PatchTerms terms_avx2(const CtChannels& ct, const PlacedPatch& patch,
                                                  double ridge, bool intensity_only) {
  return terms_of(ct, patch, ridge, intensity_only);
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

PatchTerms patch_terms(const CtChannels& ct, const PlacedPatch& patch, double ridge,
                       bool intensity_only) {
#if defined(__x86_64__)
  if (has_avx2()) return terms_avx2(ct, patch, ridge, intensity_only);
#endif
  return terms_of(ct, patch, ridge, intensity_only);
}

bool patch_intensities(const CtChannels& ct, const PlacedPatch& patch, std::span<float> f,
                       std::span<Eigen::Vector3f> by_point) {
  Samples samples;  // Not initialised: each element used is written first.
  const bool slopes = !by_point.empty();
  if (slopes ? !sample_patch<true>(ct, patch, samples) : !sample_patch<false>(ct, patch, samples)) {
    return false;
  }
  for (std::size_t k = 0; k < f.size(); ++k) {
    f[k] = samples.f[k];
    if (!std::isfinite(f[k])) return false;
    if (!slopes) continue;
    by_point[k] = {samples.df[k][0], samples.df[k][1], samples.df[k][2]};
    if (!by_point[k].allFinite()) return false;
  }
  return true;
}

}  // namespace nav::registration
