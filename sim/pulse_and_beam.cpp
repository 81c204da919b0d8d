// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/pulse_and_beam.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <tbb/parallel_for.h>

#include "sim/beam.hpp"

namespace nav::sim {
namespace {

using Complex = std::complex<float>;

constexpr std::size_t kTaps = 10;  // Half of the beam.

/// Half of a Gaussian, centre first, to three standard deviations.
std::vector<float> half_gaussian(double sigma) {
  std::vector<float> taps(static_cast<std::size_t>(std::ceil(3 * sigma)) + 1);
  for (std::size_t k = 0; k < taps.size(); ++k) {
    const auto at = static_cast<double>(k);
    taps[k] = static_cast<float>(std::exp(-0.5 * at * at / (sigma * sigma)));
  }
  return taps;
}

/// Convolution with zeros beyond the ends of the line.
void convolve(std::span<const Complex> in, std::span<const float> taps, std::span<Complex> out) {
  const std::size_t n = in.size();
  for (std::size_t i = 0; i < n; ++i) out[i] = taps[0] * in[i];
  for (std::size_t k = 1; k < std::min(taps.size(), n); ++k) {
    for (std::size_t i = k; i < n; ++i) out[i] += taps[k] * in[i - k];
    for (std::size_t i = 0; i + k < n; ++i) out[i] += taps[k] * in[i + k];
  }
}

/// Weights of the beam: taps 0 to kTaps, each for all samples.
std::vector<float> lateral_taps(const ScanGeometry& geometry, const ProbeModel& probe) {
  const auto n = static_cast<std::size_t>(geometry.samples());
  std::vector<float> taps((kTaps + 1) * n);
  for (std::size_t i = 0; i < n; ++i) {
    const double along = geometry.sample_mm() * static_cast<double>(i);
    const double sigma = sigma_lateral(probe, along) / geometry.line_spacing_mm(along);
    for (std::size_t k = 0; k <= kTaps; ++k) {
      const auto at = static_cast<double>(k);
      taps[k * n + i] = static_cast<float>(std::exp(-0.5 * at * at / (sigma * sigma)));
    }
  }
  return taps;
}

}  // namespace

double sigma_lateral(const ProbeModel& probe, double along_mm) {
  return kFwhmToSigma * probe.lateral_fwhm_mm * defocus(probe, along_mm, 1.5);
}

std::vector<Complex> pulse_and_beam(const std::vector<Complex>& points,
                                    const ScanGeometry& geometry, const ProbeModel& probe) {
  const auto n = static_cast<std::size_t>(geometry.samples());
  const std::size_t lines = points.size() / n;
  const std::vector<float> pulse =
      half_gaussian(kPulseMmTimesMhz / probe.frequency_mhz / geometry.sample_mm());
  std::vector<Complex> pulsed(points.size());
  tbb::parallel_for(std::size_t{0}, lines, [&](std::size_t l) {
    convolve(std::span(points).subspan(l * n, n), pulse, std::span(pulsed).subspan(l * n, n));
  });
  const std::vector<float> taps = lateral_taps(geometry, probe);
  std::vector<Complex> out(points.size());
  tbb::parallel_for(std::size_t{0}, lines, [&](std::size_t l) {
    const std::size_t first = l - std::min(l, kTaps);
    const std::size_t last = std::min(l + kTaps, lines - 1);
    Complex* sum = out.data() + l * n;
    for (std::size_t m = first; m <= last; ++m) {
      const Complex* in = pulsed.data() + m * n;
      const float* w = taps.data() + (m > l ? m - l : l - m) * n;
      for (std::size_t i = 0; i < n; ++i) sum[i] += w[i] * in[i];
    }
  });
  return out;
}

}  // namespace nav::sim
