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

/// What sound meets along the lines of a picture; lines x samples each. Private to sim/.
struct WayDown {
  std::vector<Tissue> tissue;
  /// Amplitude that is left after the way there and back, mean over the aperture's lines.
  std::vector<float> left;
};

/// paths: the lines where they lie at rest. absorption: by how much it varies from place to place.
WayDown way_down(const Anatomy& patient, const ScanGeometry& geometry, const ProbeModel& probe,
                 std::span<const RestPath> paths, const SmoothPatch& absorption);

/// Share of the pressure that comes back where one tissue meets another, with its sign.
double reflection(Tissue before, Tissue after);

}  // namespace nav::sim
