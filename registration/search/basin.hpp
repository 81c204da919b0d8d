// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "registration/image_registration.hpp"
#include "registration/search/costs_around.hpp"

namespace nav::registration {

/// Tells if any of the 12 poses about a pose costs less. If one does, the check continues about
/// that pose, at most kBasinSteps times. It uses no derivatives, because they may have misled the
/// solver. around must have been computed from cost and sweep.
BasinCheck check_basin(const CostsAround& around, const SimilarityCost& cost,
                       const SweepPoints& sweep);
inline constexpr int kBasinSteps = 6;

}  // namespace nav::registration
