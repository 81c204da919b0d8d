// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "bench/predicate_phantom.hpp"

namespace nav::bench {

/// Names that simulated_ultrasound() accepts, in the order of listings, separated by ", ".
std::string simulated_ultrasound_names();

/// A 3D acquisition of a simulated patient (sim/): "carotid", "carotid-2" (another patient of the
/// same family), "shoulder", "tendon"; side voxels along each axis, [16, 512]. It includes its scan
/// lines, the truth as labels (bit 0: skin and fat, bit 1: muscle, bit 2: the target tissue of the
/// family) and the predicate sets of Schulte zu Berge et al. 2014, Figures 1 and 6 to 8, but no
/// features yet. Stored values 0 to 255. kUsage, with the known names, for other names.
Result<PredicateVolume> simulated_ultrasound(const std::string& name, int side);

/// Computes the features that a model reads and a volume does not have yet; vessels of 2 to 4.5 mm
/// radius.
Result<void> add_features(const render::PredicateModel& model, PredicateVolume& volume);

}  // namespace nav::bench
