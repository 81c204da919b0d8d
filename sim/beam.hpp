// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "sim/probe_model.hpp"
#include "sim/tissue.hpp"

/// Pulse, beam and depth gain of the ray-based models. Private to sim/.
namespace nav::sim {

inline constexpr double kFwhmToSigma = 0.42466;
inline constexpr double kSpeckleCellMmTimesMhz = 1.6;
inline constexpr float kInterfaceGain = 3.5F;  // Echo of a full reflection, 1 is white.
inline constexpr float kDiffuseShare = 0.10F;  // Diffuse share of an interface echo.

/// Largest gap between face and skin that gel and a pad fill, mm.
inline double most_coupling_mm(const ProbeModel& probe) {
  constexpr double kGelMm = 14;
  return kGelMm + probe.stand_off_mm;
}

inline float amplitude_from_db(double db) { return static_cast<float>(std::pow(10.0, db / 20.0)); }

/// Unit complex number at an angle of \p turns in [0, 1], accurate to 5e-7; takes a third of the
/// time of sincosf.
inline std::complex<float> unit_phasor(float turns) {
  const int quarter = static_cast<int>(4 * turns + 0.5F);
  const float x = static_cast<float>(2 * std::numbers::pi) *
                  (turns - 0.25F * static_cast<float>(quarter));  // Within an eighth of a turn.
  const float s = x * x;
  const float sine =
      x * (1 + s * (-1.0F / 6 + s * (1.0F / 120 + s * (-1.0F / 5040 + s * (1.0F / 362880)))));
  const float cosine = 1 + s * (-0.5F + s * (1.0F / 24 + s * (-1.0F / 720 + s * (1.0F / 40320))));
  const float real = (quarter & 1) != 0 ? -sine : cosine;
  const float imaginary = (quarter & 1) != 0 ? cosine : sine;
  const float sign = (quarter & 2) != 0 ? -1.0F : 1.0F;
  return {sign * real, sign * imaginary};
}

/// Half of the symmetric pulse of about two cycles, centre first, samples step_mm apart. It has
/// unit power over scatterers that are constant within cells of cell_mm.
std::vector<float> axial_pulse(double frequency_mhz, double step_mm, double cell_mm);

/// Half of a Gaussian beam over lines spacing_mm apart, centre first. It has unit power in the same
/// sense.
void beam_taps(double sigma_mm, double spacing_mm, double cell_mm, std::span<float> taps);

/// Beam width at a depth relative to the width at the focus. \p spread: rate of widening.
double defocus(const ProbeModel& probe, double along_mm, double spread);

/// Half of the slice width (full width at half maximum) at a depth, mm.
inline double elevation_half_mm(const ProbeModel& probe, double along_mm) {
  return 0.5 * probe.elevation_fwhm_mm * defocus(probe, along_mm, 1.0);
}

/// Amplitude factor of the depth gain, including the operator's error.
std::vector<float> depth_gain(const ProbeModel& probe, std::uint64_t seed, double step_mm,
                              std::size_t samples);

/// Envelope of the bright band at the face: the transducer rings for some periods after the pulse.
/// 1 is white. \p along_mm: distance from the face.
inline float ringing(const ProbeModel& probe, double along_mm) {
  constexpr double kRingMmTimesMhz = 3.15;  // Distance over which it falls to 1/e.
  return static_cast<float>(0.6 * std::exp(-along_mm * probe.frequency_mhz / kRingMmTimesMhz));
}

/// Share of an interface echo that returns when the beam meets the interface at an angle with this
/// cosine.
inline float facing_interface(float cosine) {
  const float c2 = cosine * cosine;
  return c2 * c2 * c2 + kDiffuseShare;
}

/// Share of the scatter amplitude that returns along a beam (unit, CT axes) from fibres; 1 where
/// there are none.
inline float fibre_echo(const Acoustics& a, double x, double y, double z) {
  const auto strength2 = static_cast<double>(a.fibre[0] * a.fibre[0] + a.fibre[1] * a.fibre[1] +
                                             a.fibre[2] * a.fibre[2]);
  if (!(strength2 > 1e-6)) return 1;
  const double strength = std::sqrt(strength2);
  const double along = (x * static_cast<double>(a.fibre[0]) + y * static_cast<double>(a.fibre[1]) +
                        z * static_cast<double>(a.fibre[2])) /
                       strength;
  const double square = 1 - along * along;  // Sine squared: 1 for a perpendicular beam.
  const double facing = square * square * square * square;
  return static_cast<float>(1 - strength * (1 - facing));
}

/// Backscatter amplitude, relative to liver, that returns along a beam (unit, CT axes).
inline float scatter_along(const Acoustics& a, double x, double y, double z) {
  const float everywhere = a.scatter * fibre_echo(a, x, y, z);
  const float echo2 = a.sheet[0] * a.sheet[0] + a.sheet[1] * a.sheet[1] + a.sheet[2] * a.sheet[2];
  if (!(echo2 > 1e-6F)) return everywhere;
  const float echo = std::sqrt(echo2);
  const float along = static_cast<float>(x) * a.sheet[0] + static_cast<float>(y) * a.sheet[1] +
                      static_cast<float>(z) * a.sheet[2];
  return everywhere + echo * facing_interface(along / echo);
}

}  // namespace nav::sim
