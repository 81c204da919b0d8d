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

// Four floats in one register. The compiler's own vectors need no intrinsics and no -march.
using Float4 = float __attribute__((vector_size(16)));

// Smooths |d·G| at zero, in the unit of f: half the usual CT noise.
constexpr float kBeamEpsilon = 0.01f;
constexpr int kMaxSamples = kMaxPatchSide * kMaxPatchSide;
// Beyond this a coordinate is nonsense, and converting it to an integer undefined.
constexpr double kMaxIndex = 1e9;

Float4 load(const std::array<float, 4>& texel) {
  Float4 value;
  std::memcpy(&value, texel.data(), sizeof value);
  return value;
}

Float4 splat(float x) { return Float4{x, x, x, x}; }

/// One interpolated sample with the derivatives of the interpolant by the texel index.
struct Sample {
  Float4 value, di, dj, dk;
};

/// Trilinear interpolation at integer corner + fractions.
template <bool kDerivatives>
inline Sample interpolate(const std::array<float, 4>* corner, std::ptrdiff_t row,
                          std::ptrdiff_t slice, float wi, float wj, float wk) {
  const Float4 i = splat(wi);
  const Float4 j = splat(wj);
  const Float4 k = splat(wk);
  const Float4 t000 = load(corner[0]);
  const Float4 t010 = load(corner[row]);
  const Float4 t001 = load(corner[slice]);
  const Float4 t011 = load(corner[slice + row]);
  const Float4 d00 = load(corner[1]) - t000;
  const Float4 d10 = load(corner[row + 1]) - t010;
  const Float4 d01 = load(corner[slice + 1]) - t001;
  const Float4 d11 = load(corner[slice + row + 1]) - t011;
  const Float4 a00 = t000 + i * d00;
  const Float4 a01 = t001 + i * d01;
  const Float4 dj0 = t010 + i * d10 - a00;
  const Float4 dj1 = t011 + i * d11 - a01;
  const Float4 b0 = a00 + j * dj0;
  const Float4 b1 = a01 + j * dj1;
  Sample sample;
  sample.dk = b1 - b0;
  sample.value = b0 + k * sample.dk;
  if constexpr (kDerivatives) {
    const Float4 di0 = d00 + j * (d10 - d00);
    const Float4 di1 = d01 + j * (d11 - d01);
    sample.di = di0 + k * (di1 - di0);
    sample.dj = dj0 + k * (dj1 - dj0);
  }
  return sample;
}

/// What pass one leaves for pass two.
struct Samples {
  std::array<float, kMaxSamples> f, g;
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

inline std::ptrdiff_t offset_of(const CtChannels& ct, int i, int j, int k) {
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
void store(const Sample& sample, const Location& location, const Eigen::Vector3f& inverse,
           const Eigen::Vector3f& d, std::size_t n, Samples& out) {
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
bool sample_patch(const CtChannels& ct, const PlacedPatch& patch, Samples& out) {
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
      store<kDerivatives>(interpolate<kDerivatives>(ct.texels.data() + location.offset, row, slice,
                                                    location.w[0], location.w[1], location.w[2]),
                          location, inverse, d, n, out);
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

/// Centres f and g in place and solves for the coefficients.
Fit fit_patch(Samples& samples, std::span<const float> u, double ridge) {
  const std::size_t n = u.size();
  double mean_f = 0;
  double mean_g = 0;
  for (std::size_t k = 0; k < n; ++k) {
    mean_f += samples.f[k];
    mean_g += samples.g[k];
  }
  mean_f /= static_cast<double>(n);
  mean_g /= static_cast<double>(n);
  double ff = 0, fg = 0, gg = 0, fu = 0, gu = 0, uu = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double f = samples.f[k] - mean_f;
    const double g = samples.g[k] - mean_g;
    samples.f[k] = static_cast<float>(f);
    samples.g[k] = static_cast<float>(g);
    ff += f * f;
    fg += f * g;
    gg += g * g;
    fu += f * u[k];
    gu += g * u[k];
    uu += static_cast<double>(u[k]) * u[k];
  }
  const double damping = static_cast<double>(n) * ridge * ridge;
  ff += damping;
  gg += damping;
  const double determinant = ff * gg - fg * fg;
  Fit fit{};
  fit.inverse = {gg / determinant, -fg / determinant, ff / determinant};
  fit.c = {fit.inverse[0] * fu + fit.inverse[1] * gu, fit.inverse[1] * fu + fit.inverse[2] * gu};
  const double s = uu - fit.c[0] * fu - fit.c[1] * gu;
  // NaN first: a clamp would turn it into the perfect match 0.
  fit.s = std::isfinite(s) ? std::clamp(s, 0.0, 1.0) : std::numeric_limits<double>::quiet_NaN();
  return fit;
}

/// Sums of w wᵀ with w = [rotation 3, translation 3, f, g], of w and of (u − Ac) w.
struct Sums {
  std::array<std::array<Float4, 2>, 6> products;
  std::array<Float4, 2> plain, residual;
};

/// Pass two: V rows and their products.
Sums accumulate(const Samples& samples, const PlacedPatch& patch, const Fit& fit) {
  Sums sums{};
  const auto cf = static_cast<float>(fit.c[0]);
  const auto cg = static_cast<float>(fit.c[1]);
  const Eigen::Vector3f step_a = patch.step_a.cast<float>();
  const Eigen::Vector3f step_b = patch.step_b.cast<float>();
  const int half = (patch.side - 1) / 2;
  std::size_t n = 0;
  for (int b = -half; b <= half; ++b) {
    for (int a = -half; a <= half; ++a, ++n) {
      const Eigen::Vector3f x = static_cast<float>(a) * step_a + static_cast<float>(b) * step_b;
      const Float4 v = splat(cf) * samples.df[n] + splat(cg) * samples.dg[n];
      const Float4 e = splat(cg) * samples.spin[n];
      const Float4 low{x[1] * v[2] - x[2] * v[1] + e[0], x[2] * v[0] - x[0] * v[2] + e[1],
                       x[0] * v[1] - x[1] * v[0] + e[2], v[0]};
      const Float4 high{v[1], v[2], samples.f[n], samples.g[n]};
      const float residual = patch.u[n] - cf * samples.f[n] - cg * samples.g[n];
      for (std::size_t r = 0; r < 6; ++r) {
        const Float4 factor = splat(r < 4 ? low[r] : high[r - 4]);
        sums.products[r][0] += factor * low;
        sums.products[r][1] += factor * high;
      }
      sums.plain[0] += low;
      sums.plain[1] += high;
      sums.residual[0] += splat(residual) * low;
      sums.residual[1] += splat(residual) * high;
    }
  }
  return sums;
}

}  // namespace

double patch_cost(const CtChannels& ct, const PlacedPatch& patch, double ridge) {
  Samples samples;  // Not initialised: each element used is written first.
  if (!sample_patch<false>(ct, patch, samples)) return std::numeric_limits<double>::quiet_NaN();
  return fit_patch(samples, patch.u, ridge).s;
}

PatchTerms patch_terms(const CtChannels& ct, const PlacedPatch& patch, double ridge) {
  PatchTerms terms{std::numeric_limits<double>::quiet_NaN(), Vector6d::Zero(), Matrix6d::Zero()};
  Samples samples;  // Not initialised: each element used is written first.
  if (!sample_patch<true>(ct, patch, samples)) return terms;
  const Fit fit = fit_patch(samples, patch.u, ridge);
  if (std::isnan(fit.s)) return terms;
  const Sums sums = accumulate(samples, patch, fit);
  const auto entry = [](const std::array<Float4, 2>& row, Eigen::Index i) {
    return static_cast<double>(row[static_cast<std::size_t>(i / 4)][i % 4]);
  };
  const double count = static_cast<double>(patch.u.size());
  for (Eigen::Index r = 0; r < 6; ++r) {
    const auto& row = sums.products[static_cast<std::size_t>(r)];
    const double af = entry(row, 6);
    const double ag = entry(row, 7);
    terms.gradient[r] = -entry(sums.residual, r);
    for (Eigen::Index c = 0; c <= r; ++c) {
      const auto& other = sums.products[static_cast<std::size_t>(c)];
      const double bf = entry(other, 6);
      const double bg = entry(other, 7);
      const double projected = af * (fit.inverse[0] * bf + fit.inverse[1] * bg) +
                               ag * (fit.inverse[1] * bf + fit.inverse[2] * bg);
      terms.hessian(r, c) =
          entry(row, c) - entry(sums.plain, r) * entry(sums.plain, c) / count - projected;
      terms.hessian(c, r) = terms.hessian(r, c);
    }
  }
  if (terms.gradient.allFinite() && terms.hessian.allFinite()) {
    terms.s = fit.s;
  }
  return terms;
}

}  // namespace nav::registration
