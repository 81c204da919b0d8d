// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "sim/predicate_phantom.hpp"

namespace nav::sim {

/// Names that simulated_ultrasound() accepts, in the order of listings, separated by ", ".
std::string simulated_ultrasound_names();

/// A 3D acquisition of a simulated patient (sim/anatomy/): "carotid", "carotid-2" (another patient
/// of the same family), "shoulder" or "tendon", with side voxels along each axis, [16, 512]. Labels
/// are the truth: skin and fat (bit 0), muscle (bit 1), and the target tissue of the family (bit
/// 2). kUsage, with the known names, for other names.
Result<PredicatePhantom> simulated_ultrasound(const std::string& name, int side);

}  // namespace nav::sim
