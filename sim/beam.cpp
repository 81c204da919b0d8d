// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/beam.hpp"

#include <algorithm>
#include <numbers>

#include "sim/random.hpp"

namespace nav::sim {
namespace {

constexpr double kAxialSigmaMmTimesMhz = 1.1;  // Value for a pulse of about two cycles.

/// Correlation of the scatterers' lattice between two points: because of it, neighbours add up.
double lattice(double mm, double cell_mm) { return std::max(0.0, 1.0 - std::abs(mm) / cell_mm); }

}  // namespace

std::vector<float> axial_pulse(double frequency_mhz, double step_mm, double cell_mm) {
  const double sigma = kAxialSigmaMmTimesMhz / frequency_mhz / step_mm;
  std::vector<float> axial;
  for (int i = 0; i <= static_cast<int>(3 * sigma); ++i) {
    axial.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma))));
  }
  const int half = static_cast<int>(axial.size()) - 1;
  double power = 0;
  for (int i = -half; i <= half; ++i) {
    for (int j = -half; j <= half; ++j) {
      power += axial[static_cast<std::size_t>(std::abs(i))] *
               axial[static_cast<std::size_t>(std::abs(j))] * lattice((i - j) * step_mm, cell_mm);
    }
  }
  for (float& w : axial) w /= static_cast<float>(std::sqrt(power));
  return axial;
}

void beam_taps(double sigma_mm, double spacing_mm, double cell_mm, std::span<float> taps) {
  const int last = static_cast<int>(taps.size()) - 1;
  const double sigma = sigma_mm / spacing_mm;
  std::vector<double> w(taps.size());
  for (int k = 0; k <= last; ++k) {
    w[static_cast<std::size_t>(k)] = std::exp(-0.5 * k * k / (sigma * sigma));
  }
  double power = 0;
  for (int a = -last; a <= last; ++a) {
    for (int b = -last; b <= last; ++b) {
      power += w[static_cast<std::size_t>(std::abs(a))] * w[static_cast<std::size_t>(std::abs(b))] *
               lattice((a - b) * spacing_mm, cell_mm);
    }
  }
  for (std::size_t k = 0; k < w.size(); ++k) taps[k] = static_cast<float>(w[k] / std::sqrt(power));
}

double defocus(const ProbeModel& probe, double along_mm, double spread) {
  const double off = (along_mm - probe.focus_mm) / probe.focus_mm;
  return std::sqrt(1 + spread * off * off);
}

std::vector<float> depth_gain(const ProbeModel& probe, std::uint64_t seed, double step_mm,
                              std::size_t samples) {
  Random random(seed, 0x746763);
  const double phase = random.uniform(0, 2 * std::numbers::pi);
  std::vector<float> gain(samples);
  for (std::size_t i = 0; i < samples; ++i) {
    const double along = static_cast<double>(i) * step_mm;
    const double error = probe.tgc_error_db * std::sin(0.045 * along + phase);
    gain[i] =
        amplitude_from_db(2 * probe.tgc_db_per_cm_mhz * probe.frequency_mhz * along / 10.0 + error);
  }
  return gain;
}

}  // namespace nav::sim
