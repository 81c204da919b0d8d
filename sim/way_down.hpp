// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "sim/anatomy/anatomy.hpp"
#include "sim/motion/rest_path.hpp"
#include "sim/scan_geometry.hpp"
#include "sim/smooth_patch.hpp"

namespace nav::sim {

/// Tissue and remaining amplitude along the lines of an image; lines x samples each. Private to
/// sim/.
struct WayDown {
  std::vector<Tissue> tissue;
  /// Remaining amplitude after the way there and back, averaged over the lines of the aperture.
  std::vector<float> left;
};

/// \p paths: the lines in the tissue at rest. \p absorption: local variation of the absorption.
WayDown way_down(const Anatomy& patient, const ScanGeometry& geometry, const ProbeModel& probe,
                 std::span<const RestPath> paths, const SmoothPatch& absorption);

/// Reflected share of the pressure at the boundary of two tissues, with its sign.
double reflection(Tissue before, Tissue after);

}  // namespace nav::sim
