// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "nav/plan.hpp"
#include "sim/anatomy/abdomen_phantom.hpp"
#include "sim/random.hpp"

namespace nav::sim {

/// Region in which vessels may grow.
struct VesselTerritory {
  std::function<double(const Eigen::Vector3d&)> liver_mm;  ///< Distance; negative inside.
  NeedlePlan plan;  ///< The lesion and its path are kept free of vessels with a radius above 2 mm.
};

/// Grows the portal tree from the hilum and hepatic veins from the vena cava, branching by Murray's
/// law (r^3 = r1^3 + r2^3) down to 1.3 mm, into free space of the liver. CT coordinates.
std::vector<VesselSegment> grow_liver_vessels(const VesselTerritory& territory, Random& random);

}  // namespace nav::sim
