// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "registration/image_registration.hpp"
#include "registration/search/costs_around.hpp"

namespace nav::registration {

/// Whether any of the 12 poses about a pose costs less, and where one does, about that one, at most
/// kBasinSteps times. No derivatives, which a solver may have been led astray by. around: of cost
/// and sweep.
BasinCheck check_basin(const CostsAround& around, const Lc2Cost& cost, const SweepPoints& sweep);
inline constexpr int kBasinSteps = 6;

}  // namespace nav::registration
