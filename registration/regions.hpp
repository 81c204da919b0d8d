// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "registration/image_registration.hpp"
#include "registration/search/costs_around.hpp"

namespace nav::registration {

/// The regions that contain patches of around, of 3 along the sweep times 3 in depth; the index
/// along the sweep runs slowest. Costs are those of the patches of around, which must have been
/// computed from cost.
std::vector<RegionAgreement> region_agreement(const CostsAround& around,
                                              const SimilarityCost& cost);

}  // namespace nav::registration
