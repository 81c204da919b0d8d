// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <vector>

#include "sim/scan_geometry.hpp"

namespace nav::sim {

inline constexpr double kPulseMmTimesMhz = 1.0;  ///< Standard deviation of the pulse.

/// Standard deviation of the beam across the lines at a distance from the face, mm. Private to
/// sim/.
double sigma_lateral(const ProbeModel& probe, double along_mm);

/// Convolves point echoes (lines x samples) with pulse and beam: Gaussians along and across the
/// lines, peak 1. Private to sim/. The bytes do not depend on the number of threads.
std::vector<std::complex<float>> pulse_and_beam(const std::vector<std::complex<float>>& points,
                                                const ScanGeometry& geometry,
                                                const ProbeModel& probe);

}  // namespace nav::sim
