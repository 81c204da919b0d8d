// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "registration/image_registration.hpp"
#include "registration/lc2_cost.hpp"

namespace nav::registration {

/// The regions that have patches, of 3 along the sweep times 3 deep, along slowest.
std::vector<RegionAgreement> region_agreement(const Lc2Cost& cost, const Pose& pose);

}  // namespace nav::registration
