// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nav/result.hpp"
#include "render/predicates/volume_scene.hpp"

namespace nav::app {

/// A simulated 3D ultrasound volume with its labels and scan lines, without other features: "neck"
/// or a simulated patient (sim/predicate_patient.hpp). side: voxels along each axis, [16, 512].
/// kUsage, with the known names, for other names.
Result<render::PredicateVolume> phantom_volume(const std::string& phantom, int side);

}  // namespace nav::app
