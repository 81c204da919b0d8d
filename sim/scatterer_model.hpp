// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "sim/anatomy/anatomy.hpp"
#include "sim/motion/warp.hpp"
#include "sim/scan_geometry.hpp"

namespace nav::sim {

/// Echoes of all lines, one line after another, and the remaining amplitude of an echo from each
/// sample after the way there and back.
struct LineEchoes {
  std::vector<std::complex<float>> echo;
  std::vector<float> left;
};

/// Second acoustic model, independent of the rays of UltrasoundSimulator. Private to sim/. Point
/// scatterers, fixed in the tissue, are projected into beam coordinates with the phase of their
/// range and convolved with pulse and beam (Gao et al., COLE, 2009). Elevation is a weight of each
/// scatterer by its distance to the plane. Interfaces are rough mirrors where the tissue changes
/// along a line, found to a hundredth of a millimetre. Their echoes have a phase too: the strength
/// falls with the incidence angle because neighbouring lines cancel, not by a law. Absorption is
/// summed along the lines and averaged over the aperture.
///
/// Returns complex echoes of lines x samples before depth gain and noise, on the scale of the ray
/// model. \p look: number of an independent pattern of scatterers in the same tissue. \p warp:
/// motion of the tissue and its scatterers; nullptr: at rest. The bytes do not depend on the number
/// of threads.
struct ScattererSeed {
  std::uint64_t patient;
  std::uint64_t look = 0;
};
LineEchoes scatterer_echoes(const Anatomy& patient, const ScanGeometry& geometry,
                            const ProbeModel& probe, ScattererSeed seed,
                            const Transform<frames::Ct, frames::Image>& ct_from_image,
                            const Warp* warp);

}  // namespace nav::sim
